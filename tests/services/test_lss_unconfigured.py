"""A node that has no node id yet: silent but for LSS, until it has got one (CiA 305)."""

import pytest

from canopen_twins import Bench, UserError

from .declared import U32, bench_of, entry, record

LSS = ("LSS_Supported=0", "LSS_Supported=1")
IDENTITY = record("1018", (U32, "0x123"), (U32, "0x1"), (U32, "0x2"), (U32, "0xFFFFFFFF"))
IDENTIFIED = "7E4#4F00000000000000"
CONFIGURE, WAIT = "7E5#0401000000000000", "7E5#0400000000000000"


def new_node(folder, node_id=255, more=IDENTITY):
    return bench_of(folder, more, *LSS, node_id=node_id)


@pytest.fixture
def bench(tmp_path):
    return new_node(tmp_path)


@pytest.fixture
def lss(bench):
    master = bench.master.lss
    master.RESPONSE_TIMEOUT = 0.0
    return master


def test_it_is_silent(bench):
    assert (bench.sent, bench.state, bench.node_id) == ([], "INITIALISING", 255)
    for frame in ("6FF#4000100000000000", "000#0100", "000#8100", "080#", "77F#R"):
        assert bench.send(frame) == []
    assert bench.run(60.0) == []


def test_it_identifies_itself_as_not_configured(bench):
    assert bench.send("7E5#4C00000000000000") == ["7E4#5000000000000000"]
    bench.send(CONFIGURE)
    assert bench.send("7E5#5E00000000000000") == ["7E4#5EFF000000000000"]


def test_with_its_first_node_id_it_boots_once_it_waits_again(bench):
    bench.send(CONFIGURE)
    assert bench.send("7E5#1107000000000000") == ["7E4#1100000000000000"]
    assert bench.send("7E5#4C00000000000000") == []
    assert bench.send(WAIT) == ["707#00"]
    assert bench.send("607#4000100000000000") == ["587#4300100000000000"]
    assert bench.state == "PRE-OPERATIONAL"


def test_waiting_without_a_node_id_changes_nothing(bench):
    bench.send(CONFIGURE)
    assert bench.send(WAIT) == []
    bench.send(CONFIGURE)
    bench.send("7E5#1107000000000000")
    bench.send("7E5#11FF000000000000")
    assert bench.send(WAIT) == []


def test_a_node_id_that_is_stored_outlives_the_power_and_another_does_not(bench):
    for stores, boot in ((False, []), (True, ["707#00"])):
        bench.send(CONFIGURE)
        bench.send("7E5#1107000000000000")
        if stores:
            bench.send("7E5#1700000000000000")
        bench.send(WAIT)
        start = len(bench.sent)
        bench.power_off()
        bench.power_on()
        assert bench.sent[start:] == boot


def test_a_node_id_can_be_taken_away(tmp_path):
    bench = new_node(tmp_path, node_id=5)
    bench.send(CONFIGURE)
    assert bench.send("7E5#11FF000000000000") == ["7E4#1100000000000000"]
    assert bench.send("605#4000100000000000") != []
    assert bench.send("000#8205") == []
    assert bench.send("7E5#4C00000000000000") == ["7E4#5000000000000000"]


@pytest.mark.parametrize("node_id", [0, 128, 254])
def test_what_is_no_node_id_is_refused(bench, node_id):
    bench.send(CONFIGURE)
    assert bench.send(f"7E5#11{node_id:02X}000000000000") == ["7E4#1101000000000000"]


def test_a_fast_scan_goes_bit_by_bit_and_part_by_part(bench):
    assert bench.send("7E5#5100000000800000") == [IDENTIFIED]
    assert bench.send("7E5#51000000001F0000") == [IDENTIFIED]
    assert bench.send("7E5#51000000801F0000") == []  # bit 31 of 123h is 0
    assert bench.send("7E5#5100000000080000") == []  # bit 8 is 1
    assert bench.send("7E5#5100010000080000") == [IDENTIFIED]
    assert bench.send("7E5#5123010000000001") == [IDENTIFIED]
    assert bench.send("7E5#5123010000000001") == []  # the product code is next
    assert bench.send("7E5#5101000000000102") == [IDENTIFIED]
    assert bench.send("7E5#5102000000000203") == [IDENTIFIED]
    assert bench.send("7E5#51FFFFFFFF000300") == [IDENTIFIED]
    assert bench.send("7E5#5A00000000000000") == ["7E4#5A23010000000000"]  # it is selected
    assert bench.send("7E5#5100000000800000") == []


@pytest.mark.parametrize("part", ["200000", "000400", "00FF00"])
def test_a_fast_scan_of_what_is_not_there_is_not_answered(bench, part):
    bench.send("7E5#5100000000800000")
    assert bench.send(f"7E5#5100000000{part}") == []


def test_canopens_master_scans_configures_and_finds_the_node(bench, lss):
    found, identity = lss.fast_scan()
    assert (found, identity) == (True, [0x123, 1, 2, 0xFFFFFFFF])
    lss.configure_node_id(9)
    lss.store_configuration()
    lss.send_switch_state_global(lss.WAITING_STATE)
    assert bench.sent[-1] == "709#00"
    assert lss.fast_scan() == (False, None)


def test_several_nodes_get_their_ids_one_after_the_other(tmp_path):
    paths = [tmp_path / name for name in "ab"]
    benches = []
    for path, serial in zip(paths, ("0x11", "0x12"), strict=True):
        path.mkdir()
        benches.append(new_node(path, more=IDENTITY.replace("0xFFFFFFFF", serial)))
    pair = Bench.of({name: bench.device for name, bench in zip("ab", benches, strict=True)})
    lss = pair.master.lss
    lss.RESPONSE_TIMEOUT = 0.0
    for node_id in (7, 8):
        assert lss.fast_scan()[0]
        lss.configure_node_id(node_id)
        lss.send_switch_state_global(lss.WAITING_STATE)
    assert [frame for frame in pair.sent if frame.startswith("70")] == ["707#00", "708#00"]
    assert lss.fast_scan() == (False, None)


@pytest.mark.parametrize("identity", ["", record("1018", (U32, "0x123")), entry("1018", U32, 7)])
def test_numbers_that_the_identity_leaves_out_are_0(tmp_path, identity):
    bench = new_node(tmp_path, more=identity, node_id=5)
    bench.send(CONFIGURE)
    assert bench.send("7E5#5D00000000000000") == ["7E4#5D00000000000000"]


def test_without_lss_nobody_can_set_a_node_id(tmp_path):
    with pytest.raises(UserError, match=r"node id 255 is not in 1\.\.127"):
        bench_of(tmp_path, node_id=255)


@pytest.mark.parametrize(("lss", "node_id"), [(LSS, 255), ((), 1)])
def test_a_file_may_say_that_there_is_no_node_id(tmp_path, lss, node_id):
    more = "[DeviceComissioning]\nNodeID=255\n"
    assert bench_of(tmp_path, more, *lss, node_id=None).node_id == node_id
