"""Faults of a scenario end by themselves if they are told to."""

import pytest

STEPS = "- {at: 0, write: {Producer heartbeat: 1000}}\n"
SILENT = "inject: heartbeat_stopped"


def beats(frames_and_outcomes):
    """When there were heartbeats."""
    return [float(frame.split()[0]) for frame in frames_and_outcomes[0] if "705#7F" in frame]


def test_a_fault_heals_after_its_time(played):
    heard = beats(played(f"{STEPS}- {{at: 1.5, {SILENT}, for: 2}}\nduration: 5\n"))
    assert heard == [1, 4, 5]


def test_a_fault_heals_once_something_happens(played):
    heard = beats(
        played(
            f"{STEPS}- {{at: 1.5, {SILENT}, until: {{nmt: pre-operational}}}}\n"
            "- {at: 3.5, nmt: pre-operational}\nduration: 5\n"
        )
    )
    assert heard == [1, 4, 5]


def test_the_run_waits_for_a_fault_to_heal_after_its_time(played):
    frames, _ = played(f"{STEPS}- {{at: 1.5, {SILENT}, for: 2}}\ncleanup: [{{send: 777#}}]\n")
    assert frames[-1] == "3.5 777#"


@pytest.mark.parametrize(
    "between",
    [
        f"- {{at: 2, clear: all}}\n- {{at: 2.5, {SILENT}}}\n",
        f"- {{at: 2, clear: heartbeat_stopped}}\n- {{at: 2.5, {SILENT}}}\n",
        f"- {{at: 2.5, {SILENT}}}\n",
        f"- {{at: 2.5, {SILENT}, for: 100}}\n",
    ],
)
def test_who_takes_a_fault_away_or_replaces_it_ends_what_was_planned(played, between):
    heard = beats(
        played(f"{STEPS}- {{at: 1.5, {SILENT}, for: 2}}\n{between}- {{at: 6.5, nmt: stop}}\n")
    )
    assert [time for time in heard if time > 3] == []


def test_a_fault_that_is_injected_again_and_again_heals_each_time(played):
    heard = beats(
        played(f"{STEPS}- {{at: 1.5, {SILENT}, for: 1, every: 3, times: 2}}\nduration: 7\n")
    )
    assert heard == [1, 3, 4, 6, 7]


def test_what_heals_may_be_a_consequence_of_the_fault(played):
    frames, _ = played(
        "- {at: 1, inject: {power_cycle: {seconds: 9}}, until: {state: initialising}}\n"
    )
    assert frames[1] == "1 705#00"
