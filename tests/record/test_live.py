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
