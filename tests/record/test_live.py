import pytest


def work(master):
    """What a master does: configure, start, command by PDO, ask, and let some time pass."""
    master.hear("705#00")
    master.ask("605#2B17100014000000", "585#60171000")  # heartbeat each 20 ms
    master.ask("605#2F00180201000000", "585#60001802")  # TPDO1 with every SYNC
    master.send("000#0105")
    master.hear("705#05")
    master.send("205#0100D00700000000")
    for _ in range(5):
        master.ask("080#", "185#")
    master.ask("605#4000100000000000", "585#43001000")
    master.send("705#R")
    master.send("18FEF105#0102")
    master.hear("705#05")
    master.hear("705#05")


def test_a_live_run_is_lived_through_again_to_the_byte(live, said, tmp_path):
    code, _, err = live(work, "topcon", "-n", "5", "--record", tmp_path / "record")
    assert (code, err) == (0, "")
    trace = (tmp_path / "record" / "trace.log").read_text()
    assert " 185#" in trace
    assert " 18FEF105#0102\n" in trace
    code, out, err = said("replay", tmp_path / "record")
    assert (code, out) == (0, trace)
    assert err.startswith(f"the same {len(trace.splitlines())} frames and ")


@pytest.mark.parametrize("suffix", ["svg", "html"])
def test_a_live_run_without_a_scenario_can_be_drawn(live, said, tmp_path, suffix):
    live(work, "topcon", "-n", "5", "--record", tmp_path / "record")
    plain = said("replay", tmp_path / "record")
    path = tmp_path / f"run.{suffix}"
    assert said("replay", tmp_path / "record", "--plot", path) == plain
    text = path.read_text("utf-8")
    assert "no scenario" in text
    assert "PASS" not in text
    assert "topcon, node 5" in text.partition("Voltage")[0]


def test_a_live_run_with_a_scenario_is_lived_through_again(live, said, story, tmp_path):
    def ask(master):
        master.hear("705#00")
        for _ in range(20):
            master.ask("605#4000200000000000", "585#4B002000")
        master.hear("085#00230")
        master.send("000#8105")
        master.hear("705#00")
        master.ask("605#4000100000000000", "585#43001000")

    options = ("-n", "5", "--scenario", story(), "--record", tmp_path / "record")
    assert live(ask, "topcon", *options)[0] == 1  # ended before the scenario was
    code, out, err = said("replay", tmp_path / "record")
    assert (code, out) == (0, (tmp_path / "record" / "trace.log").read_text())
    assert err.startswith("the same ")


TWO = """\
version: 1
nodes:
  zulu: {device: topcon, node_id: 5}
  alpha: {device: topcon, node_id: 6}
steps:
  - {at: 0, node: alpha, expect: {nmt: start, within: 5}}
  - {when: {nmt: start}, node: alpha, inject: {error: {number: 0x23}}}
  - {when: {emcy: any}, node: alpha, expect: {nmt: stop, within: 5}}
  - {after: 0.01, node: zulu, write: {Producer Heartbeat Time: 10}}
  - {after: 0, node: zulu, expect: {nmt: pre-operational, within: 5}}
"""


def test_what_a_master_sets_off_in_a_scenario_is_lived_through_again(live, said, story, tmp_path):
    def react(master):
        master.hear("705#00")
        master.send("000#0106")
        master.hear("086#")
        master.send("000#0206")
        for _ in range(6):
            master.hear("705#7F")

    options = ("--scenario", story(TWO), "--record", tmp_path / "record")
    assert live(react, *options)[0] == 1
    assert '"kind": "inject"' in (tmp_path / "record" / "events.jsonl").read_text()
    trace = (tmp_path / "record" / "trace.log").read_text()
    assert said("replay", tmp_path / "record")[:2] == (0, trace)


def test_what_was_in_the_memory_is_part_of_the_record(live, said, tmp_path):
    def store(master):
        master.hear("705#00")
        master.ask("605#2B1020003C050000", "585#60102000")
        master.ask("605#2310100173617665", "585#60101001")

    def look(master):
        master.hear("705#00")
        assert master.ask("605#4010200000000000", "585#") == "585#4B1020003C050000"

    memory = ("-n", "5", "--nvram", tmp_path / "memory")
    assert live(store, "topcon", *memory)[0] == 0
    assert live(look, "topcon", *memory, "--record", tmp_path / "record")[0] == 0
    (tmp_path / "memory").unlink()
    assert said("replay", tmp_path / "record")[0] == 0
    assert not (tmp_path / "memory").exists()


BENCH = """\
version: 1
nodes:
  zulu: {device: topcon, node_id: 5}
  alpha: {device: charger, node_id: 6}
"""


def test_everybody_of_a_bench_file_is_recorded_in_their_order(live, said, tmp_path):
    def ask(master):
        master.hear("705#00")
        master.hear("706#00")
        master.send("000#0100")
        master.ask("606#4000100000000000", "586#43001000")

    (tmp_path / "bench.yaml").write_text(BENCH)
    assert live(ask, tmp_path / "bench.yaml", "--record", tmp_path / "record")[0] == 0
    code, out, _ = said("replay", tmp_path / "record")
    assert (code, out) == (0, (tmp_path / "record" / "trace.log").read_text())


def test_a_live_run_has_a_trace_file_too(live, tmp_path):
    live(work, "topcon", "-n", "5", "--trace", tmp_path / "out.trc")
    assert " Rx -  8    40 00 10 00" in (tmp_path / "out.trc").read_text()


def test_a_live_run_that_was_cut_short_is_lived_through_as_far(live, said, tmp_path):
    assert live(work, "topcon", "-n", "5", "--record", tmp_path / "record")[0] == 0
    events = tmp_path / "record" / "events.jsonl"
    *lines, end = events.read_text().splitlines(keepends=True)
    assert '"kind": "end"' in end
    events.write_text("".join(lines))
    code, out, err = said("replay", tmp_path / "record")
    assert (code, out) == (1, (tmp_path / "record" / "trace.log").read_text())
    assert "record       no more events\nreplay " in err
    assert "  -           the run is over\n" in err
