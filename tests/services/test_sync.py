import pytest
from probe import configure


@pytest.mark.spec("T-018")
@pytest.mark.parametrize("command", ["000#8005", "000#0205"])
def test_sync_has_no_effect_outside_operational(operational, command):
    operational.send("305#01000000")
    operational.send(command)
    assert operational.send("080#") == []
    operational.send("000#0105")
    assert operational.sdo["Double word"].raw == 0


@pytest.mark.spec("T-019")
def test_sync_is_never_sent(operational):
    configure(operational, "605#2B17100064000000")
    operational.run(10.0)
    assert {frame[:3] for frame in operational.sent} == {"705", "185", "585"}


def test_a_new_identifier_may_be_set_while_synchronous_pdos_run(operational):
    configure(operational, "605#2305100081000000")
    assert operational.send("081#") == ["285#00000000"]
    configure(operational, "605#2305100080000000")
    assert operational.send("080#") == ["285#00000000"]


def test_after_a_reset_sync_comes_on_its_old_identifier(operational):
    configure(operational, "605#2305100081000000")
    operational.send("000#8205")
    operational.send("000#0105")
    assert operational.send("081#") == []
    assert operational.send("080#") == ["285#00000000"]


def test_all_synchronous_pdos_hear_the_same_sync(operational):
    configure(
        operational,
        "605#23021A0110000120",
        "605#2F021A0001000000",
        "605#2F02180201000000",
        "605#2302180185030000",
    )
    assert operational.send("080#") == ["285#00000000", "385#3412"]
