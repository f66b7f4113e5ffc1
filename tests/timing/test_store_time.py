import pytest

from canopen_twins import Bench

SAVE, LOAD, WRONG = "605#2310100173617665", "605#231110016C6F6164", "605#2310100173617666"
SAVED, LOADED = "585#6010100100000000", "585#6011100100000000"
BUSY = "585#8010100100000606"


@pytest.fixture(params=["topcon", "charger", "tests/probe.eds"])
def storing(request):
    return lambda **given: Bench(request.param, node_id=5, **given)


@pytest.mark.parametrize(("command", "done"), [(SAVE, SAVED), (LOAD, LOADED)])
def test_storing_is_answered_when_it_is_done(command, done):
    bench = Bench("charger", node_id=5, store_time=0.5)
    assert bench.send(command) == []
    assert bench.run(0.49) == []
    assert bench.run(0.01) == [done]


def test_a_power_cut_meanwhile_leaves_the_memory_as_it_was(storing):
    bench = storing(store_time=0.5)
    bench.send("605#2B171000E8030000")
    bench.send(SAVE)
    bench.run(0.4)
    bench.power_off()
    bench.power_on()
    assert bench.device.memory.load("parameters") == {}


def test_a_wrong_signature_is_refused_without_it():
    assert Bench("tests/probe.eds", node_id=5, store_time=0.5).send(WRONG)[0][:6] == "585#80"


def test_other_requests_wait_for_it(storing):
    bench = storing(store_time=0.5)
    bench.send(SAVE)
    bench.send("605#4001100000000000")
    assert bench.run(0.49) == []
    assert bench.run(0.01) == [SAVED, "585#4F01100000000000"]


def test_or_it_is_answered_at_once_and_refuses_both_meanwhile(storing):
    bench = storing(store_time=0.5, store_busy="refuses")
    assert bench.send(SAVE) == [SAVED]
    assert bench.run(0.499999) == []
    assert bench.send(SAVE) == [BUSY]
    bench.run(0.000001)
    assert bench.send(SAVE) == [SAVED]


def test_restoring_keeps_it_as_busy():
    bench = Bench("charger", node_id=5, store_time=0.5, store_busy="refuses")
    assert bench.send(LOAD) == [LOADED]
    assert bench.send(SAVE) == [BUSY]
    assert bench.send(LOAD) == ["585#8011100100000606"]


def test_in_ideal_nothing_is_busy(storing):
    bench = storing()
    assert bench.send(SAVE) == [SAVED]
    assert bench.send(SAVE) == [SAVED]
