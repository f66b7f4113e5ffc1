"""What would watch to the end of a run that is over when it begins."""

import pytest

NEVER = "expect: {never: {emcy: any}}"


@pytest.fixture
def steps(problems):
    """What is wrong with them."""

    def steps(*told, more=""):
        lines = [
            "version: 1",
            "node: {device: probe}",
            "steps:",
            *(f"- {{{each}}}" for each in told),
        ]
        return problems("\n".join([*lines, more]))

    return steps


@pytest.mark.parametrize(
    ("told", "line"),
    [
        ((f"at: 0, {NEVER}",), 4),
        (("at: 1, nmt: start", f"at: 1, {NEVER}"), 5),
        ((f"after: 1, {NEVER}",), 4),
        ((f"when: {{nmt: start}}, {NEVER}",), 4),
        (("when: {nmt: start}, power: off", f"after: 1, {NEVER}"), 5),
        (("at: 0, inject: {error: {code: 1}}, until: {nmt: start}", f"at: 0, {NEVER}"), 5),
        ((f"at: 0, {NEVER}", "at: 0, expect: {value: {Byte: 0}}"), 4),
    ],
)
def test_what_must_never_come_needs_a_run_to_watch(steps, told, line):
    (problem,) = steps(*told)
    assert problem.startswith(f"{line}:3: the run may be over as soon as this begins")
    assert problem.endswith("give it 'within', or the file a 'duration'")


@pytest.mark.parametrize(
    "told",
    [
        (f"at: 0, {NEVER}", "at: 1, nmt: start"),
        (f"at: 0, {NEVER}", "after: 0, expect: {emcy: none, within: 1}"),
        (f"at: 0, {NEVER}", "after: 0, expect: {emcy: any, before: {nmt: start}}"),
        (f"at: 0, {NEVER}", "when: {nmt: start}, power: off"),
        ("at: 0, nmt: start, every: 1, times: 2", f"at: 0, {NEVER}"),
        (f"at: 0, {NEVER}, every: 1, times: 2",),
        ("at: 0, inject: {error: {code: 1}}, for: 1", f"at: 0, {NEVER}"),
        ("when: {nmt: start}, power: off", f"after: 0, {NEVER}", "at: 9, power: off"),
        ("at: 0, expect: {never: {emcy: any}, within: 0}",),
    ],
)
def test_what_lasts_longer_is_enough_of_a_run(story, told):
    assert story("".join(f"- {{{each}}}\n" for each in told))


def test_a_duration_is_a_run_and_none_is_none(steps, story):
    assert story(f"- {{at: 0, {NEVER}}}\nduration: 1\n")
    assert len(steps(f"at: 1, {NEVER}", more="duration: 1")) == 1
    assert len(steps(f"at: 0, {NEVER}", "when: {nmt: start}, power: off", more="duration: 0")) == 1


def test_the_cleanup_has_no_duration(steps):
    more = f"duration: 5\ncleanup: [{{{NEVER}}}]"
    assert steps("at: 0, nmt: start", more=more)[0].startswith("6:11: the run may be over")
