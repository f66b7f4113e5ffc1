from contextlib import suppress
from math import isfinite
from time import monotonic

import pytest

from canopen_twins import Bench, UserError, devices
from canopen_twins.faults import AIM


@pytest.fixture
def bench():
    return Bench("topcon", node_id=5)


def test_a_parameter_is_taken_as_users_write_it(bench):
    bench.inject("error", number="0x23")
    assert bench.sent == ["705#00", "085#0023032300000000"]


@pytest.mark.parametrize(
    ("fault", "given", "message"),
    [
        ("mains", {"volts": "many"}, "parameter 'volts' of fault 'mains' wants a number"),
        ("mains", {"volts": True}, "parameter 'volts' of fault 'mains' wants a number"),
        ("error", {"number": 0.5}, "parameter 'number' of fault 'error' wants a whole number"),
        ("error", {"number": 0x200}, "no unit error 0x200"),
        ("supply", {"rail": 24, "volts": 20}, "parameter 'rail' of fault 'supply' wants a text"),
        ("supply", {"rail": "24", "volts": 20}, "unknown rail '24': did you mean '24V'?"),
        ("card_error", {"code": 0x6100}, "no card error 0x6100"),
        ("error", {}, "fault 'error' wants 'number'"),
        ("error", {"nummer": 1}, "did you mean 'number'?"),
    ],
)
def test_a_wrong_parameter_is_refused_in_words(bench, fault, given, message):
    with pytest.raises(UserError) as refusal:
        bench.inject(fault, **given)
    assert message in str(refusal.value)


def test_a_setting_that_is_refused_leaves_everything_as_it_was(bench):
    bench.set(load="resistor 4")
    with pytest.raises(UserError, match="no load is called 'resitor'"):
        bench.set(load="resitor 5")
    assert bench.device.settings.load == "resistor 4"
    bench.set(ambient=40)  # which takes over the load again


@pytest.mark.parametrize("device", devices.names())
def test_a_number_of_any_size_is_taken_or_refused_in_words(device):
    bench = Bench(device, node_id=5)
    for name, fault in bench.segment.nodes[0].faults.known.items():
        given = {"frame": "585#*"} if name == "frame_swapped" else {}
        for parameter, told in fault.parameters.items():
            if told.kind not in {int, float} or (parameter in AIM and name != "frame_lost"):
                continue
            ends = (told.low, told.high, -1e18, 1e9, 1e308, -1, 0)
            for value in (told.kind(end) for end in ends if isfinite(end)):
                with suppress(UserError):
                    bench.inject(name, **given, **{parameter: value})
                    bench.run(0.003)
                bench.clear()


def test_a_frame_that_is_repeated_often_is_repeated_soon(bench):
    begun = monotonic()
    bench.inject("boot_up_repeated", repeats=1000, seconds=1e-3)
    bench.power_off()
    bench.power_on()
    bench.run(1.0)
    assert monotonic() - begun < 1.0
    with pytest.raises(UserError, match="is more than 1000"):
        bench.inject("boot_up_repeated", repeats=16000)
