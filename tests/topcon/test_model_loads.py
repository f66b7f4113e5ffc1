import pytest

from canopen_twins.devices.topcon.model.loads import (
    Battery,
    CurrentSink,
    Inductor,
    Open,
    PowerSink,
    Resistor,
    Short,
    Supercapacitor,
    parse_load,
)

TEXTS = {
    "open": Open(),
    "resistor 4": Resistor(4.0),
    "resistor 0.05": Resistor(0.05),
    "battery 350 0.1": Battery(350.0, 0.1),
    "battery 350 0.1 diode": Battery(350.0, 0.1, diode=True),
    "sink 30": CurrentSink(30.0),
    "sink 0": CurrentSink(0.0),
    "power 5000": PowerSink(5000.0),
    "power 5000 100": PowerSink(5000.0, minimum=100.0),
    "short": Short(),
    "inductor 2 0.01": Inductor(2.0, 0.01),
    "battery 350 0.1 20 soc=0.1": Battery(350.0, 0.1, capacity=20.0, soc=0.1),
    "battery 350 0.1 diode 20 swing=0.1": Battery(350.0, 0.1, True, 20.0, swing=0.1),
    "supercapacitor 10 0.01": Supercapacitor(10.0, 0.01),
    "supercapacitor 10 0.01 48": Supercapacitor(10.0, 0.01, 48.0),
}


@pytest.mark.parametrize(("text", "load"), TEXTS.items())
def test_a_load_is_its_text(text, load):
    assert parse_load(text) == load


def test_loads_of_two_texts_are_two_loads():
    assert len({*map(parse_load, TEXTS)}) == len(TEXTS)
    assert Resistor(4.0) != CurrentSink(4.0)
    assert repr(Battery(350.0, 0.1)) == "Battery(350.0, 0.1, False, 0.0, 0.5, 0.2)"


@pytest.mark.parametrize(
    ("text", "load"),
    [
        ("resistor 4 ohm", Resistor(4.0)),
        ("battery 350 V 0.1 ohm diode", Battery(350.0, 0.1, diode=True)),
        ("battery 350 0.1 ohm", Battery(350.0, 0.1)),
        ("sink 30 A", CurrentSink(30.0)),
        ("power 5000 W 100 V", PowerSink(5000.0, 100.0)),
        ("inductor 2 ohm 1e-2 H", Inductor(2.0, 0.01)),
        ("  resistor   4.0 ", Resistor(4.0)),
        ("resistor 4ohm", Resistor(4.0)),
        ("battery 350 0.1 20Ah soc=0.5", Battery(350.0, 0.1, capacity=20.0)),
        ("battery 350V 0.1 soc=1 20 Ah diode", Battery(350.0, 0.1, True, 20.0, soc=1.0)),
        ("supercapacitor 10 F 0.01 ohm 48 V", Supercapacitor(10.0, 0.01, 48.0)),
    ],
)
def test_units_and_spaces_are_welcome(text, load):
    assert parse_load(text) == load


@pytest.mark.parametrize(
    ("text", "advice"),
    [
        (
            "",
            "no load is called '': open, resistor, battery, supercapacitor, sink, power, short,"
            " inductor",
        ),
        ("resitor 4", "no load is called 'resitor', did you mean 'resistor'?: open"),
        ("Resistor 4", "no load is called 'Resistor', did you mean 'resistor'?"),
        ("resistor", "load 'resistor': ohm is not a number, write 'resistor <ohm>'"),
        ("resistor four", "load 'resistor four': ohm is not a number, write 'resistor <ohm>'"),
        ("resistor 4 A", "'A' is too much, write 'resistor <ohm>'"),
        ("resistor 4 ohm 5", "'5' is too much"),
        ("resistor -4", "ohm must be above 0"),
        ("resistor 0", "ohm must be above 0"),
        ("resistor nan", "ohm must be above 0"),
        ("resistor inf", "ohm must be above 0"),
        (
            "battery 350",
            "ohm is not a number, write"
            " 'battery <V> <ohm> [diode] [<Ah>] [soc=<0..1>] [swing=<0..1>]'",
        ),
        ("battery 350 0.1 dioed", "'dioed' is too much, write 'battery <V> <ohm> [diode] [<Ah>]"),
        ("battery 350 0.1 20 soc=half", "soc is not a number"),
        ("battery 350 0.1 20 soc=1.1", "soc must be in 0..1"),
        ("battery 350 0.1 soc=0.2", "soc is of no use without a capacity in Ah"),
        ("battery 350 0.1 -20", "capacity must be 0 or more"),
        ("supercapacitor 0 0.1", "farad must be above 0"),
        ("supercapacitor 10", "ohm is not a number, write 'supercapacitor <F> <ohm> [<V>]'"),
        ("battery -1 0.1", "volts must be 0 or more"),
        ("sink -1", "amps must be 0 or more"),
        ("sink 30 mA", "'mA' is too much, write 'sink <A>'"),
        ("power much", "watts is not a number, write 'power <W> [<V>]'"),
        ("power 5000 0", "minimum must be above 0"),
        ("inductor 2", "henry is not a number, write 'inductor <ohm> <H>'"),
        ("open 4", "'4' is too much, write 'open'"),
    ],
)
def test_a_wrong_text_is_answered_by_what_would_be_right(text, advice):
    with pytest.raises(ValueError, match=r"^[^\n]+$") as refusal:
        parse_load(text)
    assert advice in str(refusal.value)


@pytest.mark.parametrize("text", TEXTS)
def test_the_current_never_falls_with_the_voltage(text):
    load = parse_load(text)
    for voltage, current in ((0.0, 0.0), (50.0, 10.0), (400.0, 100.0)):
        conductance, _, low, high = load.line(voltage, current, 0.001)
        assert conductance >= 0.0
        assert low <= high
