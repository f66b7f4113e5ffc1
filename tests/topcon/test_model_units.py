from dataclasses import replace

import pytest

from canopen_twins.devices.topcon.model.stage import OutputStage

A = "TCP-32-400"


def test_the_file_lists_the_types_the_manual_gives_examples_of(units):
    assert list(units) == ["TCP-32-400", "TCP-16-100", "EXAMPLE-100-800-32", "TCP-32-400-IBC"]


@pytest.mark.spec("A-42")
def test_power_on_values_are_safe(units):
    stage = OutputStage(units[A])
    assert (stage.voltage_reference, stage.current_reference) == (0, 0)
    assert (stage.power_reference, stage.resistance_reference) == (32000, 0)
    assert (stage.overvoltage_level, stage.overcurrent_level) == pytest.approx((440, 110))


def test_the_droop_is_a_tenth_of_a_part_at_full_current(units):
    assert units[A].droop == pytest.approx(1e-4)
    assert units["TCP-16-100"].droop == pytest.approx(12.5e-6)


@pytest.mark.spec("A-44")
@pytest.mark.parametrize(
    ("figures", "complaint"),
    [
        ({"nominal_voltage": 400.5}, "nominal_voltage must be a whole number of V"),
        ({"maximum_current": 0.5}, "maximum_current must be a whole number of A"),
        (
            {"nominal_power": 7500},
            "nominal_power must be a whole number of kW up to 32767, not 7.5",
        ),
        ({"nominal_resistance": 0.0005}, "nominal_resistance must be a whole number of mOhm"),
        ({"nominal_resistance": 33.0}, "up to 32767, not 33000"),
        ({"nominal_voltage": 0}, "nominal_voltage must be above 0"),
        ({"capacitance": -1e-3}, "capacitance must be above 0, not -0.001"),
        ({"bleeder": float("inf")}, "bleeder must be"),
        ({"efficiency": 93.0}, "efficiency must be in 0..1, not 93"),
        ({"start_slope": 0.5}, "slopes must be in 1..32000"),
        ({"run_slope": 40000}, "slopes must be in 1..32000"),
        ({"sink_current": -1.0}, "sink_current must be"),
    ],
)
def test_a_unit_type_that_cannot_be_is_refused(units, figures, complaint):
    with pytest.raises(ValueError, match=r"^unit type 'TCP-32-400': [^\n]+$") as refusal:
        replace(units[A], **figures)
    assert complaint in str(refusal.value)


@pytest.mark.spec("T-160", "A-74")
def test_a_parallel_system_shows_the_sum_of_currents(units):
    system = replace(units[A], sink_current=30.0).system(3, "parallel")
    assert (system.nominal_voltage, system.maximum_current) == (400, 300)
    assert (system.nominal_power, system.nominal_resistance) == (96_000, 1.333)
    assert system.sink_current == 90
    assert system.name == "3 x TCP-32-400 parallel"


@pytest.mark.spec("T-160", "A-74")
def test_a_series_system_shows_the_sum_of_voltages(units):
    system = units[A].system(2, "series")
    assert (system.nominal_voltage, system.maximum_current) == (800, 100)
    assert (system.nominal_power, system.nominal_resistance) == (64_000, 8)


@pytest.mark.parametrize(("count", "connection"), [(0, "parallel"), (2, "delta")])
def test_a_system_needs_units_and_a_way_to_wire_them(units, count, connection):
    with pytest.raises(ValueError, match="parallel or series"):
        units[A].system(count, connection)


@pytest.mark.parametrize(
    ("connection", "ohm"), [("parallel", 2.0), ("series", 8.0)], ids=["parallel", "series"]
)
def test_a_system_on_its_share_of_the_load_behaves_as_one_unit(running, connection, ohm):
    full = (4000, 3000, 4000, 0)
    one = running(load="resistor 4", parts=full)
    two = running(load=f"resistor {ohm}", parts=full, units=2, connection=connection)
    assert two.power == pytest.approx(2 * one.power)
    assert two.temperature == pytest.approx(one.temperature)
    assert two.unit.bleeder * two.unit.capacitance == pytest.approx(1.0)
    assert two.mode is one.mode


def test_a_parallel_system_fills_its_i2t_store_as_fast_as_one_unit(running):
    limits = {"i2t_current": 50.0, "i2t_limit": 1e6}
    full = (4000, 4000, 4000, 0)
    one = running(load="resistor 4", parts=full, figures=limits)
    two = running(load="resistor 2", parts=full, figures=limits, units=2)
    assert two.store.charge / two.unit.i2t_limit == pytest.approx(
        one.store.charge / one.unit.i2t_limit
    )
