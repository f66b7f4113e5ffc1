"""The reference masters keep their contracts in a hunt; mutants of them do not."""

import shutil

import pytest

from canopen_twins import play
from canopen_twins.hunt.contract import Contract, Plan
from canopen_twins.hunt.run import run
from canopen_twins.hunt.search import Hunt
from canopen_twins.scenario import load

from .mutants import DEVICES, EXAMPLES, UntilFound, mutants

MUTANTS = mutants()


class AsFound(UntilFound):
    """Nor is a find made simpler: it is to be simple before."""

    to_shrink = 0.0


@pytest.fixture
def hunted(here, tmp_path):
    """The report of a hunt for some runs."""

    def hunted(contract, runs):
        budget = AsFound(runs=runs)
        hunt = Hunt(Contract(contract), budget=budget, folder=tmp_path)
        budget.report = hunt.report
        return hunt.hunt()

    return hunted


@pytest.mark.parametrize(("device", "runs"), [("topcon", 30), ("charger", 6), ("gateway", 4)])
def test_a_reference_master_survives(hunted, tmp_path, device, runs):
    for file in EXAMPLES.glob(f"{device}_*"):
        shutil.copy(file, tmp_path)
    report = hunted(tmp_path / f"{device}_contract.yaml", runs)
    assert [str(find.outcome) for find in report.finds] == []
    assert report.runs >= runs


@pytest.mark.parametrize("name", ["toggle ignored", "one loss ends it"])
def test_a_mutant_is_found_with_one_thing_beyond_the_contract(hunted, tmp_path, name):
    (mutant,) = [each for each in MUTANTS if each.name == name]
    report = hunted(mutant.put_into(tmp_path), 60)
    assert [find.plan.size for find in report.finds] == [1]


def test_an_answer_that_comes_just_too_late_is_tried(hunted, tmp_path):
    (mutant,) = [each for each in MUTANTS if each.name == "late answer taken for the next"]
    contract = mutant.put_into(tmp_path)
    contract.write_text(contract.read_text() + "space: {faults: [sdo_silence, sdo_late]}\n")
    (find,) = hunted(contract, 50).finds
    assert (find.plan.faults, find.plan.size) == (("sdo_late",), 1)


WRONG = {
    "run before operational": {"frame_lost": {"frame": "000#*", "times": 2}},
    "abort read as data": {"sdo_abort": {"object": "Nominal voltage", "times": 1}},
    "size ignored": {"sdo_wrong_size": {"object": "Nominal voltage", "times": 1}},
    "emergency only logged": {"error": {"number": 0x23}},
    "heartbeat not missed": "heartbeat_stopped",
}
"""What has to go wrong, for some of them."""
LATER = ("emergency only logged", "heartbeat not missed")


@pytest.mark.parametrize("name", WRONG)
def test_what_a_mutant_does_not_survive_its_master_does(tmp_path, name):
    (mutant,) = [each for each in MUTANTS if each.name == name]
    plan = Plan(({"at": 2.7 if name in LATER else 0.0, "inject": WRONG[name]},))
    contract = mutant.put_into(tmp_path)
    assert run(Contract(contract), plan).failures
    assert not run(Contract(EXAMPLES / contract.name), plan).failures


@pytest.mark.parametrize("mutant", MUTANTS, ids=str)
def test_without_any_fault_a_mutant_keeps_its_contract(tmp_path, mutant):
    assert play(load(mutant.put_into(tmp_path))).ok


def test_they_are_of_all_devices_and_each_has_its_name():
    assert len({str(each) for each in MUTANTS}) == len(MUTANTS) >= 20
    assert {each.device for each in MUTANTS} == {*DEVICES}


def failures(device, wrong, **more):
    """Those of the reference master when this goes wrong."""
    return run(Contract(EXAMPLES / f"{device}_contract.yaml"), Plan(wrong, **more)).failures


def test_a_release_that_has_no_effect_is_no_failure_when_a_boot_up_message_is_lost():
    """The charger is pre-operational then: nobody has told its master that it has forgotten all."""
    lost = {"frame_lost": {"times": 1}}
    wrong = ({"at": 5, "inject": {"brown_out": {"times": 1}}}, {"at": 5, "inject": lost})
    assert not failures("charger", wrong)


def test_a_command_that_meets_a_boot_up_message_is_no_failure_when_it_is_withdrawn_at_once():
    """0.05 s of no supply and 0.3 s of boot are a time-out of 0.3 s and a pause: RUN comes then."""
    wrong = ({"when": {"write": {"Run command": 1}}, "inject": {"brown_out": {"times": 1}}},)
    assert not failures("topcon", wrong)


def test_an_emergency_that_tells_of_an_end_is_none_to_react_to():
    wrong = ({"at": 1, "inject": {"emcy_storm": {"times": 1, "code": 0}}},)
    assert not failures("topcon", wrong)


def test_heartbeats_that_are_lost_while_the_master_waits_for_an_answer_are_missed():
    """Two of them, and the answer: the next heartbeat is there before the main thread can look."""
    wrong = ({"at": 2, "inject": {"frame_lost": {"times": 3}}},)
    assert not failures("topcon", wrong)


def test_a_supply_that_has_left_the_bus_with_an_error_need_not_obey():
    wrong = ({"at": 10, "inject": {"emcy_storm": {"times": 1}}}, {"at": 10, "inject": "bus_off"})
    assert not failures("topcon", wrong)


def test_an_error_that_comes_just_after_another_is_answered_with_another_stop():
    """While the master waits for a new start."""
    storm = {"emcy_storm": {"times": 2, "seconds": 0.02}}
    wrong = ({"at": 5, "inject": storm}, {"at": 5.1, "inject": "sdo_silence", "for": 2})
    assert not failures("topcon", wrong)


def test_a_supply_that_takes_long_to_boot_is_not_reset_before_it_is_there():
    wrong = ({"when": {"state": "pre-operational"}, "inject": "power_cycle", "for": 1},)
    slow = (("topcon", "boot_time", 3.0),)
    assert not failures("topcon", wrong, settings=slow, arbitration="identifier")


def test_a_charger_that_has_healed_may_be_released_after_half_a_second():
    """Its heartbeat comes just then, so that nothing else is waited for."""
    wrong = ({"at": 0.5, "inject": "overtemperature", "for": 0.5},)
    assert not failures("charger", wrong, arbitration="master")


def test_errors_that_are_there_before_anybody_listens_are_cleared_though_only_one_is_known():
    """The charger keeps the last one only (0x1003)."""
    wrong = tuple({"at": 0, "inject": {"error": {"number": number}}} for number in (2, 11))
    assert not failures("charger", wrong, settings=(("charger", "timing", "worst"),))


def test_an_error_that_is_told_late_may_be_reset_by_then():
    """The command is withdrawn before it is told of, and asking for the state has shown it."""
    when = {"when": {"write": {"Producer Heartbeat Time": 500}}}
    late = {"frame_jitter": {"times": 1, "seconds": 0.05}}
    wrong = ({**when, "inject": {"sense_offset": {"volts": 30.0}}}, {**when, "inject": late})
    assert not failures("topcon", wrong)
