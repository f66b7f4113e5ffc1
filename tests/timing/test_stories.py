"""Shipped scenarios at nodes that take their time.

All of them are played with `typical` and with `worst`, about 10 s of a processor each. What has to
be seen may come later by all that the preset allows a node, and measured values may be off by their
noise; everything else is as the file says. A story that is about times themselves is an exception,
with its reason.
"""

from dataclasses import replace
from functools import lru_cache

import pytest
from played import SCENARIOS

from canopen_twins.device.timing import PRESETS
from canopen_twins.scenario import load, play
from canopen_twins.scenario.actions import Expectation, Read
from canopen_twins.scenario.frame_matchers import AnyFrame
from canopen_twins.scenario.matchers import Holds
from canopen_twins.scenario.scenario import NodeSpec
from canopen_twins.scenario.values import Range

BOOTING = "asks or expects something within the boot time of a reset or a power cycle"
STORING = "switches off while it is stored"
ANSWERING = "counts what comes, asks again or acts within the time of an answer"
MEASURING = "looks for what lasts no longer than a refresh"
ALWAYS = {
    "charger_lss": BOOTING,
    "charger_release": MEASURING,
    "topcon_brown_out": BOOTING,
    "topcon_bus_full": ANSWERING,
    "topcon_power_cycle": BOOTING,
    "topcon_short_circuit": MEASURING,
}
EXCEPTIONS = {
    "typical": ALWAYS,
    "worst": {
        **ALWAYS,
        "charger_autostart": STORING,
        "charger_hardware": BOOTING,
        "charger_not_saved": STORING,
        "charger_operator": STORING,
        "charger_sdo_refused": ANSWERING,
        "charger_timeout_too_short": BOOTING,
        "charger_twice": BOOTING,
        "gateway_bus_load": ANSWERING,
        "gateway_sdo_refused": ANSWERING,
        "topcon_battery_above_level": ANSWERING,
        "topcon_battery_charged": BOOTING,
        "topcon_boot_up_lost": BOOTING,
        "topcon_boot_up_repeated": BOOTING,
        "topcon_bus_trouble": ANSWERING,
        "topcon_configuration_refused": ANSWERING,
        "topcon_cyclic_run": ANSWERING,
        "topcon_duplicate_node_id": BOOTING,
        "topcon_hardware_and_software_errors": BOOTING,
        "topcon_master_dies": BOOTING,
        "topcon_power_cycle": STORING,
        "topcon_reset_loop": BOOTING,
        "topcon_sdo_while_stopped": ANSWERING,
    },
}
TO_THE_DIGIT = {
    "charger_values_frozen",
    "topcon_configuration_refused",
    "topcon_duplicate_node_id",
    "topcon_frames_corrupted",
    "topcon_frames_out_of_order",
    "topcon_gate_driver",
    "topcon_heartbeat_irregular",
    "topcon_pdo_disturbed",
    "topcon_pdo_frozen",
    "topcon_sdo_late",
}
"""They tell measured values by frames; they are played without noise."""


def grown(wanted, measured, noise):
    return tuple(
        (target, replace(value, low=value.low - noise, high=value.high + noise))
        if isinstance(value, Range) and target.address in measured
        else (target, value)
        for target, value in wanted
    )


def patient(action, measured, timing):
    """The same, with room for a node that takes its time."""
    if isinstance(action, Read):
        return replace(action, uploads=grown(action.uploads, measured, timing.noise))
    if not isinstance(action, Expectation):
        return action
    matcher = action.matcher
    if isinstance(matcher, Holds):
        matcher = replace(matcher, wanted=grown(matcher.wanted, measured, timing.noise))
    if action.never or isinstance(matcher, AnyFrame) or action.seconds is None:
        return replace(action, matcher=matcher)
    answer = 3 * (timing.answer_time + timing.answer_jitter)
    late = timing.boot_time + answer + timing.store_time + timing.measure_time
    return replace(action, matcher=matcher, within=action.seconds + late)


loaded = lru_cache(1)(load)
"""A file is loaded once for both presets."""


def slowed(path, preset):
    scenario = loaded(path)
    quiet = {"noise": 0} if path.stem in TO_THE_DIGIT else {}
    nodes = {
        name: NodeSpec(spec.device, {"timing": preset, **quiet, **spec.settings})
        for name, spec in scenario.nodes.items()
    }
    measured = {address for spec in nodes.values() for address in spec.create().measured}
    steps = [
        replace(step, action=patient(step.action, measured, PRESETS[preset]))
        for step in scenario.steps
    ]
    return replace(scenario, nodes=nodes, steps=tuple(steps))


@pytest.mark.parametrize("preset", ["typical", "worst"])
@pytest.mark.parametrize("path", SCENARIOS, ids=lambda path: path.stem)
def test_a_story_that_is_not_about_times_comes_out_as_told(path, preset):
    verdict = play(slowed(path, preset))
    assert verdict.ok is (path.stem not in EXCEPTIONS[preset]), str(verdict)
