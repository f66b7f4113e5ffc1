"""What the twins of files do on the bus that declare a service."""

import pytest

from canopen_twins import Bench

from .conftest import FILES


@pytest.fixture
def bench():
    return lambda name: Bench(str(FILES / name), node_id=5)


def test_a_file_with_a_guard_time_is_guarded(bench):
    twin = bench("60_guarding.eds")
    assert [*twin.send("705#R"), *twin.send("705#R")] == ["705#7F", "705#FF"]


def test_a_file_that_consumes_heartbeats_tells_a_silent_node(bench):
    twin = bench("64_heartbeat_consumer.eds")
    assert twin.send("605#23161001C8007F00") == ["585#6016100100000000"]
    assert twin.send("77F#05") == []
    assert twin.run(1.0) == ["085#3081110000000000"]
    assert twin.send("77F#05") == ["085#0000000000000000"]


def test_a_file_without_an_error_register_has_0_in_its_emergencies(bench):
    twin = bench("26_no_error_register.eds")
    twin.inject("error_passive")
    assert twin.run(0.1) == ["085#2081000000000000"]


def test_a_file_with_lss_is_asked_for_its_node_id(bench):
    twin = bench("68_lss_supported.eds")
    assert twin.send("7E5#0401000000000000") == []
    assert twin.send("7E5#5E00000000000000") == ["7E4#5E05000000000000"]
    assert twin.send("7E5#5B00000000000000") == ["7E4#5B00000000000000"]


@pytest.mark.parametrize(
    "name", ["26_no_error_register.eds", "66_error_history_with_gaps.eds", "60_guarding.eds"]
)
def test_its_pdo_follows_sync_as_that_of_any_file(bench, name):
    twin = bench(name)
    twin.send("000#0105")
    assert twin.send("080#") == ["185#0900"]


@pytest.mark.parametrize("index", [0x2002, 0x2003])
def test_a_domain_and_bytes_are_read_as_they_stand(bench, index):
    twin = bench("21_domain_and_octet_string.eds")
    assert bytes(twin.sdo.upload(index, 0)) == b"\x01\x02\xff"


def test_a_limit_of_a_signed_value_is_signed(bench):
    twin = bench("54_limits_of_a_signed_value_as_hex.eds")
    assert twin.send("605#2B022000EBFF0000") == ["585#8002200032000906"]
    assert twin.send("605#2B02200065000000") == ["585#8002200031000906"]
    assert twin.send("605#2B022000ECFF0000") == ["585#6002200000000000"]
