import pytest

from canopen_twins.device.faults import Fault, Faults, Parameter, arguments
from canopen_twins.errors import UserError

NUMBER = Parameter("which one")
SIZE = Parameter("how much", 10)


@pytest.fixture
def log():
    return []


@pytest.fixture
def faults(log):
    return Faults(
        {
            "lasting": Fault(
                "stays until it is cleared",
                lambda number, size: log.append(("inject", number, size)),
                lambda number, size: log.append(("clear", number, size)),
                {"number": NUMBER, "size": SIZE},
            ),
            "passing": Fault("is over at once", lambda: log.append("passing")),
        }
    )


def test_a_fault_is_injected_and_cleared_with_the_same_parameters(faults, log):
    faults.inject("lasting", number=3)
    assert faults.active == {"lasting": {"number": 3, "size": 10}}
    faults.clear("lasting")
    assert (faults.active, log) == ({}, [("inject", 3, 10), ("clear", 3, 10)])


def test_a_fault_that_is_active_already_is_replaced(faults, log):
    faults.inject("lasting", number=3)
    faults.inject("lasting", number=4, size=1)
    assert log == [("inject", 3, 10), ("clear", 3, 10), ("inject", 4, 1)]


def test_a_fault_without_clear_is_never_active(faults, log):
    faults.inject("passing")
    assert (faults.active, log) == ({}, ["passing"])
    faults.clear("passing")
    assert log == ["passing"]


def test_clearing_without_a_name_clears_all_that_is_active(faults, log):
    faults.clear()
    faults.inject("lasting", number=3)
    faults.clear()
    faults.clear()
    assert (faults.active, log[1:]) == ({}, [("clear", 3, 10)])


def test_what_is_not_active_is_cleared_without_effect(faults, log):
    faults.clear("lasting")
    assert log == []


def test_a_fault_that_has_healed_is_not_active_and_is_cleared_all_the_same(log):
    healed = []
    faults = Faults(
        {
            "short": Fault(
                "heals",
                lambda: log.append("inject"),
                lambda: log.append("clear"),
                over=lambda: bool(healed),
            )
        }
    )
    faults.inject("short")
    assert list(faults.active) == ["short"]
    healed.append(True)
    assert list(faults.active) == []
    faults.clear()
    assert log == ["inject", "clear"]


def test_what_is_around_a_device_is_not_injected_again_when_its_power_comes(log):
    around = {"line": Fault("around", lambda: log.append("line"), lambda: None)}
    own = {"own": Fault("own", lambda: log.append("own"), lambda: None)}
    faults = Faults(own, around)
    faults.inject("line")
    faults.inject("own")
    log.clear()
    faults.renew(own)
    assert log == ["own"]


def test_after_a_power_cycle_the_faults_are_those_of_the_model_that_is_there_now(log):
    def told(model):
        act, undo = log.append, lambda: log.append(f"{model} is free")
        return {"own": Fault("own", lambda: act(f"{model} is stuck"), undo)}

    faults = Faults(told("the first"))
    faults.inject("own")
    faults.renew(told("the second"))
    faults.clear("own")
    assert log == ["the first is stuck", "the second is stuck", "the second is free"]


def test_what_is_active_can_be_injected_again_as_it_was(faults, log):
    faults.inject("lasting", number=3)
    faults.inject("passing")
    log.clear()
    faults.renew(faults.known)
    assert log == [("inject", 3, 10)]


@pytest.mark.parametrize("act", [Faults.inject, Faults.clear])
def test_an_unknown_fault_is_an_error_with_the_nearest_known_one(faults, act):
    with pytest.raises(UserError, match=r"'lasing'.*'lasting'"):
        act(faults, "lasing")


def test_an_unknown_parameter_is_an_error_with_the_nearest_known_one(faults, log):
    with pytest.raises(UserError, match=r"'nummer'.*'number'"):
        faults.inject("lasting", nummer=3)
    assert (faults.active, log) == ({}, [])


def test_a_missing_parameter_is_an_error_that_says_what_it_means(faults, log):
    with pytest.raises(UserError, match="'number': which one"):
        faults.inject("lasting", size=3)
    assert (faults.active, log) == ({}, [])


def test_the_arguments_of_a_fault_are_known_before_it_is_injected(faults, log):
    fault = faults.known["lasting"]
    assert arguments("lasting", fault, {"number": 3}) == {"number": 3, "size": 10}
    assert log == []
