import re
from pathlib import Path

import pytest
from played import SCENARIOS

from canopen_twins import devices
from canopen_twins.scenario import load, play
from tools import report
from tools.proofs import Proof, prove, shipped
from tools.rows import Row, faults, faults_of_all, messages, stories

pytestmark = pytest.mark.timeout(300)  # whoever comes first plays all scenarios

TESTS = Path(__file__).parent
SCENARIO = """
version: 1
name: A story
note: Of one device.
node: {{device: {device}, node_id: 1}}
{rest}
"""


def read(path):
    return path.read_text("utf-8")


def proof_of(folder, device, *steps, covers=""):
    path = folder / f"{device}_story.yaml"
    rest = f"{covers}\nsteps:\n" + "\n".join(f"  - {{{step}}}" for step in steps)
    path.write_text(SCENARIO.format(device=device, rest=rest), "utf-8")
    scenario = load(path)
    return prove(scenario, play(scenario))


def proven(rows, proof):
    return {row.name for row in rows if row.proven(proof)}


@pytest.fixture(scope="module")
def proofs(played):
    """What every shipped scenario proves."""
    return [prove(run.scenario, run.verdict) for run in map(played, SCENARIOS)]


def test_the_page_is_what_playing_the_scenarios_gives(proofs):
    assert report.PAGE.read_text("utf-8") == report.page(report.sections(), proofs), (
        "python -m tools.report writes it"
    )


def test_nothing_that_can_go_wrong_is_without_a_scenario(proofs):
    assert list(report.unproven(report.sections(), proofs)) == []


def test_what_a_scenario_is_about_is_a_statement_that_a_test_proves_as_well(proofs):
    tested = set(re.findall(r"[TCG]-\d{3}", "".join(map(read, TESTS.rglob("test_*.py")))))
    assert {name for proof in proofs for name in proof.covers} <= tested


@pytest.mark.parametrize("device", shipped())
def test_a_device_has_lines_for_all_it_tells_and_all_its_faults(device):
    whole = devices.create(device)
    names = [row.name for row in messages(device)]
    assert [name for name in names if not name.endswith(" gone")] == list(whole.messages)
    assert [row.name for row in faults(device)] == [f"`{name}`" for name in whole.faults]
    assert len({row.name for row in stories(device)}) == len(list(stories(device))) > 0


def test_faults_that_every_device_has_are_there_once():
    assert len(list(faults_of_all())) == 37


def test_a_bit_counts_for_the_value_that_came_and_for_no_other(tmp_path):
    steps = [
        "at: 1, inject: {reset: {unit: gateway}}",
        "at: 2, expect: {value: {CanOpen Errors: 0x0100}}",
        "at: 2, expect: {value: {CanOpen Errors: 0x0002}}",
        "at: 2, expect: {value: {CanOpen Errors: {min: 1}}}",
    ]
    assert proven(messages("gateway"), proof_of(tmp_path, "gateway", *steps)) == {"12419"}


def test_a_value_that_is_read_counts_as_well(tmp_path):
    steps = [
        "at: 1, inject: {reset: {unit: gateway}}",
        "at: 2, read: {CanOpen Errors: 0x0100}",
    ]
    assert proven(messages("gateway"), proof_of(tmp_path, "gateway", *steps)) == {"12419"}


def test_a_bit_is_gone_when_it_was_told_before(tmp_path):
    steps = [
        "at: 0.5, expect: {value: {CanOpen Errors: 0}}",
        "at: 1, inject: {reset: {unit: gateway}}",
        "at: 2, read: {CanOpen Errors: 0x0100}",
        "at: 2, nmt: start",
    ]
    gone = "12419 gone"
    assert gone not in proven(messages("gateway"), proof_of(tmp_path, "gateway", *steps))
    steps.append("at: 2, expect: {value: {CanOpen Errors: 0}, within: 0.1}")
    assert gone in proven(messages("gateway"), proof_of(tmp_path, "gateway", *steps))


def test_an_emergency_counts_by_its_code_and_only_if_it_came(tmp_path):
    steps = [
        "at: 1, inject: interlock_open",
        "at: 1, expect: {emcy: {code: 0x9000}, within: 0.1}",
        "at: 1, expect: {emcy: {code: 0x2300}, within: 0.1}",
        "at: 1, expect: {never: {emcy: {code: 0x3300}}, within: 0.1}",
    ]
    assert proven(messages("topcon"), proof_of(tmp_path, "topcon", *steps)) == {"0x9000"}


def test_messages_with_one_code_are_told_apart_by_their_number(tmp_path):
    steps = [
        "at: 1, inject: {error: {key: hardware}}",
        "at: 1, expect: {emcy: {code: 0x5000}, within: 1}",
    ]
    assert proven(messages("charger"), proof_of(tmp_path, "charger", *steps)) == set()
    steps[1] = "at: 1, expect: {emcy: {code: 0x5000, detail: 0x0B01}, within: 1}"
    assert proven(messages("charger"), proof_of(tmp_path, "charger", *steps)) == {"error 0x0b"}


def test_a_fault_counts_if_something_that_came_was_expected_after_it(tmp_path):
    steps = [
        "at: 1, inject: link_cut",
        "at: 1, inject: {sdo_late: {seconds: 2}}",
        "at: 2, expect: {silence: true, within: 1}",
        "at: 3, inject: overspeed",
    ]
    proof = proof_of(tmp_path, "gateway", *steps)
    assert proven(faults("gateway"), proof) == {"`link_cut`"}
    assert proven(faults_of_all(), proof) == {"`sdo_late`"}
    assert proven(faults("topcon"), proof) == set()


def test_a_story_counts_if_all_of_it_passes(tmp_path):
    covers = "covers: [G-132]"
    good = proof_of(
        tmp_path, "gateway", "at: 1, expect: {heartbeat: any, within: 1.1}", covers=covers
    )
    assert proven(stories("gateway"), good) == {"G-132"}
    bad = proof_of(tmp_path, "gateway", "at: 1, expect: {silence: true, within: 2}", covers=covers)
    assert proven(stories("gateway"), bad) == set()


def test_a_line_without_a_scenario_is_told():
    rows = [Row(name, "what", lambda proof, name=name: name == "A") for name in ("A", "B")]
    missing = report.unproven([report.Section("All", tuple(rows))], [Proof("", (), {})])
    assert list(missing) == ["All: B what"]
