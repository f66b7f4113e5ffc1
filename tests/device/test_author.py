"""What the author of a device is told when something is wrong with it, in one line."""

import inspect
from pathlib import Path
from typing import get_type_hints

import pytest

import canopen_twins
from canopen_twins import Bench, device
from canopen_twins.device import Abort, Chart, Curve, Fault, Object, Rejected
from canopen_twins.errors import UserError
from canopen_twins.record.plot.run import Run

FAN = Path(__file__).parents[2] / "docs" / "examples" / "canopen-fan" / "canopen_fan" / "fan.eds"
PROBE = str(Path(__file__).parents[1] / "probe.eds")


class Fan(device.Device):
    """One that is right; `value` is what its speed reads."""

    eds = str(FAN)
    title = "Fan of a test"
    value: object = 0

    @property
    def objects(self):
        return {(0x2001, 0): Object(read=lambda: self.value)}


def told(make):
    """The one line of a mistake."""
    with pytest.raises(UserError) as mistake:
        make()
    (line,) = str(mistake.value).splitlines()
    return line


def test_one_that_is_right_boots():
    assert Bench.of({"fan": Fan(node_id=9)}).sent == ["709#00"]


def test_an_object_that_is_not_in_the_eds():
    class Wrong(Fan):
        @property
        def objects(self):
            return {(0x6099, 0): Object(read=lambda: 0)}

    line = told(lambda: Bench.of({"fan": Wrong()}))
    assert line == "Wrong: its EDS fan.eds has no entry 0x6099:00, which is among its objects"


@pytest.mark.parametrize(
    ("value", "what"),
    [
        (1.6, "reads 1.6, which does not fit UNSIGNED16, 2 would"),
        (None, "reads None, which does not fit UNSIGNED16"),
        (70_000, "reads 70000, which does not fit UNSIGNED16"),
        ("fast", "reads 'fast', which does not fit UNSIGNED16"),
        (float("nan"), "reads nan, which does not fit UNSIGNED16"),
    ],
)
def test_a_read_that_gives_what_the_entry_cannot_hold(value, what):
    bench = Bench.of({"fan": Fan()})
    bench.device.value = value
    line = told(lambda: bench.send("601#4001200000000000"))
    assert line == f"Fan: the object 0x2001:00 'Actual speed' {what}"


def test_a_read_that_gives_a_number_for_a_text():
    class Wrong(Fan):
        eds = PROBE

        @property
        def objects(self):
            return {(0x2005, 0): Object(read=lambda: 7)}

    bench = Bench.of({"fan": Wrong()})
    line = told(lambda: bench.send("601#4005200000000000"))
    assert line.endswith("'Text' reads 7, which does not fit VISIBLE_STRING")


@pytest.mark.parametrize(
    ("name", "example"), [("title", "Maker, name (manual)"), ("eds", "fan.eds")]
)
def test_a_class_without_what_every_device_has(name, example):
    members = {"eds": str(FAN), "title": "Fan of a test"}
    members.pop(name)
    wrong = type("Wrong", (device.Device,), members)
    line = told(lambda: Bench.of({"fan": wrong()}))
    assert line == f'Wrong has no {name}: write {name} = "{example}"'


def test_an_eds_that_is_not_there():
    class Wrong(Fan):
        eds = "/nowhere/fan.eds"

    line = told(lambda: Bench.of({"fan": Wrong()}))
    assert line == "Wrong: there is no EDS /nowhere/fan.eds; eds is a path to one"


def test_a_refusal_with_its_arguments_the_wrong_way_round():
    line = told(lambda: Rejected(Abort.TOO_HIGH, "too fast"))
    assert line.startswith("Rejected(<Abort.TOO_HIGH: 101253169>, 'too fast'): the reason comes")
    assert line.endswith('Rejected("too fast", Abort.TOO_HIGH)')


class Model:
    def __init__(self, number):
        self.number = number
        self.hit = False

    def strike(self):
        self.hit = True


class Capturing(Fan):
    """Its objects, faults and chart hold the model of the moment at which they were asked for."""

    made = 0

    def make_model(self):
        self.made += 1
        self.model = Model(self.made)

    @property
    def objects(self):
        model = self.model
        return {(0x2001, 0): Object(read=lambda: model.number)}

    @property
    def faults(self):
        return {"strike": Fault("It is hit.", self.model.strike)}

    @property
    def chart(self):
        model = self.model
        return Chart([Curve("Number", "", lambda: model.number)])


def test_there_is_a_model_before_there_is_power():
    assert Capturing().model.number == 1


def test_every_power_on_makes_a_model_and_nothing_acts_on_the_one_before():
    bench = Bench.of({"fan": Capturing()})
    assert bench.values("Actual speed") == {"Actual speed": 2}
    bench.power_off()
    bench.power_on(node_id=9)
    number = bench.device.model.number
    assert bench.values("Actual speed") == {"Actual speed": number}
    bench.inject("strike")
    assert bench.device.model.hit


def test_a_picture_draws_the_model_that_is_there_after_a_power_on():
    bench = Bench.of({"fan": Capturing()})
    observer = Run(bench.segment, None)
    bench.run(1.0)
    bench.power_off()
    bench.power_on()
    bench.run(1.0)
    ((strip,),) = (node.curves for node in observer.nodes)
    assert [point.value for point in strip.actual.points] == [2, 3]


def test_settings_that_no_model_can_be_made_of_are_refused_and_the_others_stay():
    class Choosy(Fan):
        def make_model(self):
            if self.node_id > 9:
                raise UserError("no model for so many")

    fan = Choosy(node_id=9)
    assert told(lambda: fan.configure(node_id=10)) == "no model for so many"
    assert fan.node_id == 9


def hooks():
    """Every method and property of a device that its author may write anew."""
    members = vars(device.Device).items()
    for name, member in members:
        function = member.fget if isinstance(member, property) else member
        if inspect.isfunction(function) and not name.startswith("_"):
            yield function


@pytest.mark.parametrize("hook", list(hooks()), ids=lambda hook: hook.__name__)
def test_what_a_hook_takes_and_gives_comes_from_the_same_import(hook):
    spoken = str(list(get_type_hints(hook).values()))
    for word in spoken.replace("[", " ").replace("]", " ").replace(",", " ").split():
        if word.startswith("canopen_twins."):
            assert hasattr(device, word.split(".")[-1]), word


def test_the_door_has_all_of_the_api_of_devices():
    assert set(device.__all__) <= set(canopen_twins.__all__)
    for name in device.__all__:
        assert getattr(canopen_twins, name) is getattr(device, name)
