import pytest
from charger_bus import put

from canopen_twins import Bench
from canopen_twins.devices.charger.model.discharging import Bars, Dirt, Discharge
from canopen_twins.devices.charger.model.load import Web
from canopen_twins.devices.charger.model.messages import Severity
from canopen_twins.devices.charger.model.parameters import Parameter
from canopen_twins.devices.charger.model.release import ReleaseSource
from canopen_twins.devices.charger.model.types import PCSC, Variant


@pytest.fixture
def discharging(make):
    """A PCSC/A that discharges without a software release."""
    charger = make(
        PCSC, Variant.A, mode_discharging=1, software_release_discharging=0, limiter_warning=1
    )
    charger.step(0.01)
    return charger


def now(charger):
    return charger.discharging.now


@pytest.mark.spec("C-200")
def test_5_kv_at_50_hz_drive_942_ua_and_118_mw_into_each_connector(discharging):
    assert now(discharging).voltage == 5000
    assert now(discharging).current == pytest.approx(942e-6, abs=0.5e-6)
    assert now(discharging).powers == pytest.approx((0.118, 0.118), abs=0.0005)
    assert now(discharging).power == pytest.approx(0.2356, abs=0.0001)


@pytest.mark.spec("C-196")
@pytest.mark.parametrize(
    ("index", "frequency"),
    list(enumerate([50, 55.56, 62.5, 71.43, 83.33, 100, 125, 166.67, 250])),
)
def test_the_current_follows_the_frequency(discharging, index, frequency):
    discharging.write(Parameter.VOLTAGE_SETPOINT_DISCHARGING, 1000)
    discharging.write(Parameter.FREQUENCY_DISCHARGING, index)
    discharging.step(0.01)
    assert now(discharging).current == pytest.approx(1000 * 6.2832 * frequency * 0.6e-9, rel=1e-4)


@pytest.mark.spec("C-194")
def test_above_the_current_setpoint_the_voltage_gives_way(discharging, active):
    discharging.write(Parameter.FREQUENCY_DISCHARGING, 8)
    discharging.step(0.01)
    assert now(discharging).limited
    assert now(discharging).current == pytest.approx(3000e-6)
    assert now(discharging).voltage == pytest.approx(3183, abs=1)
    discharging.step(1.0)
    assert active(discharging) == [("WARNING", "limiter_discharging")]


def test_heat_limits_the_power_of_the_discharging(discharging):
    warm = discharging.heating.at(discharging.now)["discharging"]
    discharging.surround(heat={"discharging": 79.7 - warm})
    discharging.step(2.0)
    assert now(discharging).limited
    assert now(discharging).power == pytest.approx(discharging.derating.discharging, rel=0.01)
    assert discharging.derating.discharging == pytest.approx(0.1, abs=0.02)


@pytest.mark.spec("C-200")
def test_a_web_brings_its_charge_along(discharging):
    discharging.surround(web=Web(width=1.5, speed=2.0, surface_charge=5e-6))
    discharging.step(0.01)
    assert now(discharging).direct_current == pytest.approx(-15e-6)


@pytest.mark.spec("C-201")
def test_the_adjustment_shifts_the_direct_current(discharging):
    discharging.write(Parameter.ADJUSTMENT_DISCHARGING, 100)
    discharging.step(0.01)
    assert now(discharging).direct_current == pytest.approx(0.05 * now(discharging).current)


@pytest.mark.spec("C-194")
def test_a_passive_bar_has_no_voltage_and_takes_off_a_part(make):
    charger = make(PCSC, Variant.A, mode_discharging=0)
    charger.surround(web=Web(width=1.5, speed=2.0, surface_charge=5e-6))
    charger.grant(ReleaseSource.CANOPEN)
    charger.step(0.01)
    assert not charger.discharging_active
    assert now(charger).voltage == now(charger).current == 0
    assert now(charger).direct_current == pytest.approx(-4.5e-6)


@pytest.mark.spec("C-191")
def test_a_charger_without_discharging_measures_nothing_there(make):
    charger = make(mode_discharging=1, software_release_discharging=0)
    charger.surround(web=Web(speed=2.0))
    charger.step(1.0)
    assert not charger.discharging_active
    assert now(charger) == Discharge()


@pytest.mark.spec("C-197")
@pytest.mark.parametrize("software", [False, True])
@pytest.mark.parametrize("hardware", [False, True])
@pytest.mark.parametrize("counts", [0, 1])
def test_the_software_release_counts_for_the_discharging_if_it_shall(
    make, software, hardware, counts
):
    charger = make(PCSC, Variant.A, mode_discharging=1, software_release_discharging=counts)
    charger.surround(hardware_release_discharging=hardware)
    if software:
        charger.grant(ReleaseSource.CANOPEN)
    assert charger.discharging_active is (hardware and (software or not counts))


@pytest.mark.spec("C-143")
def test_an_error_switches_the_discharging_off_too(discharging, catalogue):
    assert discharging.discharging_active
    discharging.force(catalogue.keyed(Severity.ERROR, "discharging_short"))
    assert not discharging.discharging_active


@pytest.mark.spec("C-194", "C-197")
@pytest.mark.parametrize("superset", [False, True])
def test_by_the_letter_a_c_discharges_whatever_its_settings(make, superset):
    charger = make(PCSC, Variant.C, superset=superset)
    assert charger.discharging_active is not superset


@pytest.mark.spec("C-192")
@pytest.mark.parametrize("variant", [Variant.A, Variant.C])
@pytest.mark.parametrize(
    ("power", "dirt"),
    [
        ((1.0, 1.0), (Dirt.NONE, Dirt.NONE)),
        ((1.6, 0.4), (Dirt.CONDUCTIVE, Dirt.INSULATING)),
        ((0.6, 1.4), (Dirt.NONE, Dirt.NONE)),
    ],
)
def test_a_c_tells_the_dirt_on_its_discharging_bars(make, active, variant, power, dirt):
    charger = make(
        PCSC,
        variant,
        mode_discharging=1,
        software_release_discharging=0,
        pollution_detection_discharging=1,
        nominal_power_1=118,
        nominal_power_2=118,
    )
    charger.surround(bars=Bars(power=power))
    charger.step(0.01)
    told = dirt if variant is Variant.C else (Dirt.NONE, Dirt.NONE)
    assert charger.dirt == told
    warned = [int(key[-1]) for _, key in active(charger)]
    assert warned == [place for place, found in enumerate(told, start=1) if found]


@pytest.mark.spec("C-198")
def test_a_minute_of_calibration_gives_the_nominal_powers(make):
    charger = make(PCSC, Variant.C, superset=True, mode_discharging=1)
    charger.write(Parameter.POLLUTION_DETECTION_DISCHARGING, 2)
    charger.surround(bars=Bars(power=(1.0, 2.0)))
    charger.step(600.0)
    assert charger.parameters[Parameter.NOMINAL_POWER_1] == 0
    charger.grant(ReleaseSource.CANOPEN)
    charger.step(59.99)
    assert charger.parameters[Parameter.POLLUTION_DETECTION_DISCHARGING] == 2
    charger.step(0.01)
    assert charger.parameters[Parameter.POLLUTION_DETECTION_DISCHARGING] == 1
    assert charger.parameters[Parameter.NOMINAL_POWER_1] == 118
    assert charger.parameters[Parameter.NOMINAL_POWER_2] == 236


@pytest.mark.spec("C-199")
def test_a_nominal_power_stays_within_its_range(make):
    charger = make(PCSC, Variant.A, mode_discharging=1, software_release_discharging=0)
    charger.write(Parameter.POLLUTION_DETECTION_DISCHARGING, 2)
    charger.surround(bars=Bars(power=(100.0, 1.0)))
    charger.step(60.0)
    assert charger.parameters[Parameter.NOMINAL_POWER_1] == 1000


@pytest.mark.spec("C-198")
def test_the_comparison_does_not_depend_on_what_is_set(make):
    charger = make(PCSC, Variant.C, nominal_power_1=118, nominal_power_2=118)
    charger.write(Parameter.VOLTAGE_SETPOINT_DISCHARGING, 1000)
    charger.write(Parameter.FREQUENCY_DISCHARGING, 8)
    charger.step(0.01)
    assert charger.dirt == (Dirt.NONE, Dirt.NONE)


@pytest.mark.spec("C-198")
@pytest.mark.parametrize(("series", "told"), [("R60", True), ("R60L", True), ("R50", False)])
def test_only_bars_of_the_r60_series_tell_their_dirt(make, series, told):
    charger = make(PCSC, Variant.C, nominal_power_1=118)
    charger.surround(bars=Bars(series=series, power=(2.0, 1.0)))
    charger.step(0.01)
    assert (charger.dirt[0] is Dirt.CONDUCTIVE) is told


@pytest.mark.spec("C-198")
@pytest.mark.parametrize("again", ["restart", "write"])
def test_a_calibration_that_begins_again_takes_its_minute_again(discharging, again):
    discharging.write(Parameter.POLLUTION_DETECTION_DISCHARGING, 2)
    discharging.step(40.0)
    if again == "restart":
        discharging.restart({Parameter.POLLUTION_DETECTION_DISCHARGING: 2})
    else:
        discharging.write(Parameter.POLLUTION_DETECTION_DISCHARGING, 2)
    discharging.step(59.99)
    assert discharging.parameters[Parameter.NOMINAL_POWER_1] == 0
    discharging.step(0.01)
    assert discharging.parameters[Parameter.NOMINAL_POWER_1] == 118


@pytest.mark.spec("C-198")
def test_the_reference_point_is_driven_to_whatever_is_set(discharging):
    discharging.write(Parameter.VOLTAGE_SETPOINT_DISCHARGING, 2000)
    discharging.write(Parameter.FREQUENCY_DISCHARGING, 8)
    discharging.step(1.0)
    assert now(discharging).voltage == 2000
    discharging.write(Parameter.POLLUTION_DETECTION_DISCHARGING, 1)
    discharging.step(1.0)
    assert now(discharging).voltage == 5000
    assert now(discharging).current == pytest.approx(942e-6, abs=0.5e-6)
    discharging.step(0.01)
    assert now(discharging).voltage == 2000
    discharging.step(598.99)
    assert now(discharging).voltage == 2000
    discharging.step(0.01)
    assert now(discharging).voltage == 5000


@pytest.mark.spec("C-198")
def test_dirt_is_found_at_the_reference_point_and_told_until_the_next(make, active):
    charger = make(
        PCSC,
        Variant.A,
        superset=True,
        mode_discharging=1,
        software_release_discharging=0,
        voltage_setpoint_discharging=2000,
        pollution_detection_discharging=1,
        nominal_power_1=118,
        nominal_power_2=118,
    )
    charger.step(10.0)
    charger.surround(bars=Bars(power=(1.6, 0.4)))
    charger.step(589.99)
    assert charger.dirt == (Dirt.NONE, Dirt.NONE)
    charger.step(0.02)
    assert charger.dirt == (Dirt.CONDUCTIVE, Dirt.INSULATING)
    assert [key for _, key in active(charger)] == [
        "pollution_discharging_1",
        "pollution_discharging_2",
    ]
    charger.step(30.0)
    assert charger.dirt == (Dirt.CONDUCTIVE, Dirt.INSULATING)


@pytest.mark.spec("C-192", "C-198")
@pytest.mark.parametrize(("policy", "dirt"), [("letter", 0), ("superset", 1)])
def test_an_a_shows_what_it_finds_if_both_variants_have_all_of_each_other(policy, dirt):
    bench = Bench("charger", variant="A", variant_policy=policy)
    put(bench, {0x22: 1, 0x27: 0, 0x29: 118, 0x2A: 118, 0x28: 1})
    bench.inject("discharging_pollution", connector=1, percent=200)
    bench.run(0.1)
    assert bench.sdo[0x6000][7].raw == dirt
