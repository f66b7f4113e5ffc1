"""What people write by mistake, and that the answer has what would be right."""

import re

import pytest

from canopen_twins import Bench, UserError
from canopen_twins.bus import vcan
from canopen_twins.cli import main
from canopen_twins.scenario import load

HEAD = "version: 1\nnode: {device: topcon, node_id: 5}\nsteps:\n"


@pytest.fixture
def told(tmp_path):
    """What is said of a scenario with this step."""

    def told(step, head=HEAD):
        path = tmp_path / "slip.yaml"
        path.write_text(head + step + "\n", "utf-8")
        with pytest.raises(UserError) as refusal:
            load(path)
        return str(refusal.value).replace(f"{path}:", "")

    return told


@pytest.mark.parametrize(
    ("step", "answer"),
    [
        ("  - {at: 100ms, nmt: start}", "4:10: '100ms' is no number: write 0.1"),
        ("  - {at: 2s, nmt: start}", "4:10: '2s' is no number: write 2"),
        ("  - {at: 1.5 min, nmt: start}", "4:10: '1.5 min' is no number: write 90"),
        ("  - {at: 250us, nmt: start}", "4:10: '250us' is no number: write 0.00025"),
        ("  - {at: '0.1', nmt: start}", "4:10: '0.1' stands in quotes and is a text: write 0.1"),
        ("  - at: 0,1\n    nmt: start", "4:9: '0,1' is no number: write 0.1, with a point"),
        (
            "  - {at: 0.1, expect: {emcy: any, within: 0,1}}",
            "4:45: unknown key '1': a comma ends the value before it, write 0.1 with a point",
        ),
        ("  - {at: 0.1, set: {ambient: 25degC}}", "not '25degC': write 25"),
        ("  - {at: 0.1, set: {ambient: 25 °C}}", "not '25 °C': write 25"),
        ("  - {at: 0.1, inject: {mains: {volts: 300V}}}", "not '300V': write 300"),
    ],
)
def test_a_number_with_a_unit_quotes_or_a_comma(told, step, answer):
    assert answer in told(step)


@pytest.mark.parametrize(
    ("step", "answer"),
    [
        ("\t- {at: 0.1, nmt: start}", "4:1: a tab: indent with spaces"),
        ("  - at: 0.1\n\t  nmt: start", "5:1: a tab: indent with spaces"),
        ("  - {at:0.1, nmt: start}", "4:6: unknown key 'at:0.1': a space is missing, at: 0.1"),
        ("  - at:0.1", "4:5: a space is missing after the colon: at: 0.1"),
        ("  - at:0.1\n    nmt: start", "4:5: a space is missing after the colon: at: 0.1"),
        ("  - {at: 0.1, inject: heartbeat_lost}", "did you mean 'heartbeat_stopped'?"),
        ("  - {at: 0.1, expect: {emcy:any, within: 1}}", "a space is missing, emcy: any"),
    ],
)
def test_a_tab_and_a_colon_without_a_space(told, step, answer):
    assert answer in told(step)


@pytest.mark.parametrize(
    ("written", "meant"),
    [
        ("operational", "start"),
        ("stopped", "stop"),
        ("preop", "pre-operational"),
        ("reset", "reset-node"),
    ],
)
def test_a_state_is_not_the_command_that_leads_there(told, written, meant):
    assert f"unknown NMT command '{written}': did you mean '{meant}'?" in told(
        f"  - {{at: 0.1, nmt: {written}}}"
    )


@pytest.mark.parametrize("load", ["resistor 4ohms", "resistor 4 Ohm", "resistor 4 Ω", "resistor 4"])
def test_a_load_is_understood_with_its_units(load):
    Bench("topcon", node_id=5, load=load)


def test_a_load_in_other_units_is_told_which_are_meant():
    with pytest.raises(UserError, match="ohm is not a number, write 'resistor <ohm>'"):
        Bench("topcon", node_id=5, load="resistor 4k")


def test_a_code_without_0x_is_said_to_be_decimal(tmp_path, caplog):
    path = tmp_path / "slip.yaml"
    step = "  - {at: 0.1, expect: {emcy: {code: 2300}, within: 1}}\n"
    path.write_text(HEAD + step, "utf-8")
    load(path)
    told = "2300 is decimal, 0x08FC: write 0x2300 if you mean that code"
    assert caplog.messages == [f"{path}:4:37: {told}"]


def test_a_step_with_only_a_condition_waits(tmp_path):
    path = tmp_path / "wait.yaml"
    path.write_text(
        f"{HEAD}  - {{when: {{heartbeat: any}}}}\n  - {{after: 0, set: {{ambient: 30}}}}\n",
        "utf-8",
    )
    waiting, _ = load(path).steps
    assert str(waiting.action) == "wait"


@pytest.mark.parametrize(
    ("asked", "told"),
    [
        ("heartbeat_lost", "did you mean 'heartbeat_stopped'?"),
        ("overvoltage", "did you mean 'error'?"),
        ("OVP", "did you mean 'error'?"),
        ("sdo-timeout", "did you mean 'sdo_silence'?"),
        ("brownout", "did you mean 'brown_out'?"),
        ("frame missing", "did you mean 'frame_lost'?"),
        ("heartbeat_sopped", "did you mean 'heartbeat_stopped'?"),
    ],
)
def test_a_fault_is_found_by_the_words_of_the_field(asked, told):
    with pytest.raises(UserError, match=re.escape(told)):
        Bench("topcon", node_id=5).inject(asked)


def test_a_short_circuit_is_a_fault_of_the_charger():
    with pytest.raises(UserError, match="did you mean 'short'"):
        Bench("charger", node_id=5).inject("short_circuit")


def test_a_parameter_without_its_name_is_told_how_it_is_written():
    told = re.escape("inject('error', NAME=35)")
    with pytest.raises(UserError, match=told):
        Bench("topcon", node_id=5).inject("error", 0x23)


@pytest.mark.parametrize("seconds", [-1, "1s", "1", None, float("nan"), float("inf")])
def test_a_bench_runs_for_some_seconds_only(seconds):
    with pytest.raises(UserError, match=r"such as run\(0.5\)"):
        Bench("topcon", node_id=5).run(seconds)


def test_a_node_id_that_is_none_is_one_line_without_the_usage(capsys):
    with pytest.raises(SystemExit):
        main(["run", "topcon", "-n", "abc"])
    (line,) = capsys.readouterr().err.splitlines()
    assert line.endswith("a node id is a whole number of 1..127, such as 5 or 0x05, not 'abc'")


@pytest.mark.skipif(vcan.is_up(), reason="where there is a vcan0 the bus opens")
def test_a_machine_without_vcan0_is_told_what_brings_one(capsys):
    assert main(["run", "topcon", "-i", "socketcan", "-c", "vcan0"]) == 2
    assert "`canopen-twin vcan -- COMMAND`" in capsys.readouterr().err


def test_why_tells_what_an_object_takes(capsys):
    assert main(["why", "topcon", "0x2014"]) == 0
    assert "no command 65535: 0 stops, 1 runs, 2 resets" in capsys.readouterr().out
    assert main(["why", "charger", "0x2002:08"]) == 0
    assert "65535 is above 30000" in capsys.readouterr().out
