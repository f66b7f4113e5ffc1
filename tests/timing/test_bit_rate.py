import logging

import pytest

from canopen_twins import Bench
from canopen_twins.cli import main
from canopen_twins.diagnosis.why import why
from canopen_twins.scenario import load, play

READ, ANSWER = "605#4000100000000000", "585#4300100091010000"
SILENT = "its bit rate is 125000 bit/s, that of the bus 500000"


@pytest.fixture
def charger():
    """At 125 kbit/s, on a bus of 500."""
    bench = Bench("charger", node_id=5)
    bench.segment.bit_rate = 500_000
    return bench


def test_a_node_of_another_bit_rate_does_not_hear(charger):
    assert charger.send("000#0105") == []
    assert charger.state == "PRE-OPERATIONAL"
    assert charger.send(READ) == []


def test_nor_is_it_heard(charger):
    assert charger.run(5.0) == []  # its heartbeat is 1 s


def test_until_both_agree(charger):
    charger.segment.bit_rate = 125_000
    assert charger.send(READ) == [ANSWER]


def test_why_says_so(charger):
    charger.send(READ)
    told = why(charger.node, charger.trace)
    assert f"{READ} not answered: {SILENT} (manual, SDO Transfer)" in told
    assert f"the node neither hears nor is heard: {SILENT}" in told[-1]


def test_who_has_lss_activate_another_is_lost_until_the_bus_has_it_too():
    bench = Bench("charger", node_id=5)
    bench.segment.bit_rate = 125_000
    bench.send("7E5#0401000000000000")
    assert bench.send("7E5#1300020000000000") == ["7E4#1300000000000000"]
    bench.send("7E5#1564000000000000")
    bench.run(1.0)
    assert bench.send(READ) == []
    bench.segment.bit_rate = 500_000
    assert bench.send(READ) == [ANSWER]
    bench.segment.bit_rate = 125_000
    bench.power_off()
    bench.power_on()
    assert bench.send(READ) == [ANSWER]


def test_the_switch_of_a_topcon_is_read_at_power_on():
    bench = Bench("topcon", node_id=5, br=4)
    bench.segment.bit_rate = 500_000
    assert bench.send(READ) == []
    bench["topcon"].set(br=6)
    assert bench.send(READ) == []
    bench.power_off()
    bench.power_on()
    assert len(bench.send(READ)) == 1


def test_the_gateway_has_parameter_426():
    bench = Bench("gateway", node_id=5)
    bench.run(1.0)
    bench.segment.bit_rate = 125_000
    assert len(bench.send(READ)) == 1
    bench.segment.bit_rate = 250_000
    assert bench.send(READ) == []


def test_without_a_bit_rate_everybody_fits():
    assert Bench("charger", node_id=5).send(READ) == [ANSWER]
    nobody_knows = Bench("tests/probe.eds", node_id=5)
    nobody_knows.segment.bit_rate = 10_000
    assert len(nobody_knows.send(READ)) == 1


def test_what_it_sends_takes_no_time_of_the_bus():
    bench = Bench.of({"charger": ("charger", 5), "topcon": ("topcon", 6)})
    bench.segment.limit(500_000)
    start = bench.clock.now
    bench.send("606#4000100000000000")
    while not bench.run(1e-5):
        pass
    alone = bench.clock.now - start
    assert alone < 0.0006
    assert bench.run(3.0) == []


STORY = """\
version: 1
node: {{device: topcon, node_id: 5, settings: {{br: {br}}}}}
bit_rate: 125000
steps:
  - {{at: 0.1, read: {{Device Type: any}}}}
"""


@pytest.mark.parametrize(("br", "ok"), [(4, True), (6, False)])
def test_a_scenario_with_a_bit_rate_has_no_node_of_another(tmp_path, br, ok):
    path = tmp_path / "story.yaml"
    path.write_text(STORY.format(br=br), "utf-8")
    verdict = play(load(path))
    assert verdict.ok is ok
    told = "its bit rate is 500000 bit/s, that of the bus 125000"
    assert (told in str(verdict)) is not ok


def test_run_warns_of_those_that_do_not_meet(caplog, monkeypatch):
    monkeypatch.setattr("canopen_twins.cli.run.serve", lambda *_: None)
    bus = ("-i", "virtual", "-c", "meet", "-b", "500000")
    with caplog.at_level(logging.WARNING):
        assert main(["run", "charger", *bus]) == 0
        assert main(["run", "topcon", *bus]) == 0
    assert caplog.messages == ["charger has 125000 bit/s, the bus 500000: they do not meet"]
