"""Steps of scenarios, one for each verdict."""

PASSING = "- {at: 0.1, expect: {value: {Nominal voltage: 400}}}"
FAILING = "- {at: 0.1, expect: {value: {Nominal voltage: 401}}}"
BROKEN = "- {at: 0.1, write: {Run command: 3}}"
