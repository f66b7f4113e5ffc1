import logging

import pytest
import yaml
from charger_bus import START, put, release, status, value
from charger_files import entries

from canopen_twins import Bench, UserError


@pytest.mark.spec("C-111", "C-156", "A-71")
@pytest.mark.parametrize(
    ("kind", "mode", "voltage", "current"),
    [
        ("PCSC", 3, 1500, 5000),
        ("PCMT", 4, 3000, 2500),
        ("PCRT", 3, 1000, 10_000),
        ("PCTL", 5, 1000, 5000),
    ],
)
@pytest.mark.parametrize("variant", ["base", "A", "C"])
def test_every_type_and_variant_boots_with_its_own_factory_settings(
    kind, variant, mode, voltage, current
):
    bench = Bench("charger", kind=kind, variant=variant)
    assert bytes(bench.sdo.upload(0x1008, 0)) == kind.encode()
    assert [value(bench, sub) for sub in (0x10, 0x08, 0x09)] == [mode, voltage, current]
    assert len(bench.send(START)) == 3
    bench.run(1.0)


@pytest.mark.spec("C-190", "A-20")
def test_a_c_may_have_everything_of_an_a():
    def objects(**settings):
        return entries(Bench("charger", **settings).device.dictionary()).keys()

    superset = objects(variant="C", variant_policy="superset")
    assert superset == objects(variant="A") > objects(variant="C")


@pytest.mark.spec("C-192", "A-20")
def test_and_still_tells_what_is_wrong_with_its_bars():
    bench = Bench("charger", variant="C", variant_policy="superset")
    put(bench, {0x22: 1, 0x27: 0, 0x28: 2})
    bench.run(61.0)
    assert [value(bench, sub) for sub in (0x28, 0x29, 0x2A)] == [1, 118, 118]
    bench.inject("discharging_pollution", percent=10)
    bench.run(0.1)
    assert value(bench, 7, 0x6000) == 2


@pytest.mark.spec("C-198", "A-77")
def test_bars_of_another_series_cannot_be_watched():
    bench = Bench("charger", variant="C", bars="other")
    put(bench, {0x29: 118, 0x2A: 118})
    bench.inject("discharging_pollution", percent=10)
    bench.run(1.0)
    assert value(bench, 7, 0x6000) == 0


@pytest.mark.spec("C-170", "C-171", "A-56")
def test_a_level_may_be_the_bare_number():
    bench = Bench("charger", spark_value="number")
    release(bench)
    counted = []
    for slope in (25.0, 25.1):  # mA/ms: 40 * 5 / 8 = 25
        bench.inject("spark", slope=slope)
        bench.run(0.1)
        counted.append(value(bench, 0x08, 0x2001))
    assert counted == [0, 1]


@pytest.mark.spec("C-173", "A-57")
@pytest.mark.parametrize(
    ("classes", "counts"),
    [("exclusive", [1, 0, 0, 0]), ("per_class", [1, 0, 1, 0]), ("cumulative", [1, 1, 1, 1])],
)
def test_one_spark_may_raise_several_counters(classes, counts):
    bench = Bench("charger", spark_classes=classes)
    release(bench)
    bench.inject("spark", slope=0.3)
    assert [value(bench, sub, 0x2001) for sub in range(0x08, 0x0C)] == counts


@pytest.mark.spec("C-162", "A-73")
def test_the_load_may_be_a_resistor_and_change_while_running(on):
    for load in ("resistor 20e6", "resistor 20000000 ohm"):
        on.set(load=load)
        on.run(0.1)
        assert value(on, 2, 0x6401) == 1000
    on.set(load="bar")
    on.run(0.1)
    assert value(on, 2, 0x6401) == 2000


@pytest.mark.spec("C-162", "C-200", "A-76")
def test_a_moving_web_takes_charge_along(on):
    on.set(web_speed=10.0, web_width=2.0)
    on.run(0.1)
    assert value(on, 2, 0x6401) == 2400
    on.set(web_speed=0.0)
    bench = Bench("charger", variant="A", web_speed=2.0, web_charge=10.0)
    bench.run(0.1)
    assert value(bench, 7, 0x6401) == -9  # passive


@pytest.mark.spec("C-183", "A-75")
def test_the_air_may_be_another(bench):
    bench.set(ambient=40.0)
    bench.run(36_000.0)
    assert [value(bench, sub, 0x2001) for sub in (5, 6, 7)] == [46, 43, 40]


@pytest.mark.spec("C-034", "A-37")
def test_the_numbers_of_the_operating_manual_replace_ours(catalogue_data, tmp_path, caplog):
    rows = [row for row in catalogue_data["errors"] if row["key"] != "output_short"]
    rows = [{**row, "number": 0x4F - row["number"]} for row in rows]
    path = tmp_path / "messages.yaml"
    path.write_text(yaml.safe_dump({**catalogue_data, "assumed": False, "errors": rows}))
    with caplog.at_level(logging.WARNING):
        bench = Bench("charger", messages=str(path), heartbeat_default_ms=0)
    assert "error 'output_short' has no message" in caplog.text
    bench.inject("error", key="hardware")
    assert bench.sent[-1] == "0E3#0050010144000000"
    bench.clear()
    put(bench, {1: 0x44}, index=0x2003)
    release(bench)
    bench.inject("short")
    assert bench.run(3.0) == ["0E3#0023030509000000"]  # the limiter, but no short


REFUSED = [
    ({"kind": "PCXX"}, "one of PCSC, PCMT, PCRT, PCTL"),
    ({"variant": "B"}, "one of base, A, C"),
    ({"node_id": 0}, "'node_id' is 1 to 127, not 0"),
    ({"node_id": 128}, "'node_id' is 1 to 127, not 128"),
    ({"messages": "nowhere.yaml"}, "nowhere.yaml: "),
    ({"firmware": "1.0"}, "four ASCII characters"),
    ({"firmware": "1.0é"}, "four ASCII characters"),
    ({"heartbeat_default_ms": 150}, "'heartbeat_default_ms': 150 ms is no multiple of 100"),
    ({"heartbeat_default_ms": 50}, "'heartbeat_default_ms': 50 ms is below 100"),
    ({"load": "resistor"}, "'load' is 'bar' or 'resistor OHM', not 'resistor'"),
    ({"load": "bar 5"}, "'load' is 'bar'"),
    ({"load": ""}, "'load' is 'bar'"),
    ({"load": "resistor many"}, "'load': the resistor wants a number, not 'many'"),
    ({"load": "resistor 0"}, "'load': a resistor of 0 ohm is none"),
]


@pytest.mark.parametrize(("given", "told"), REFUSED, ids=str)
def test_what_cannot_be_is_told_in_one_line(given, told):
    with pytest.raises(UserError) as refusal:
        Bench("charger", **given)
    assert told in str(refusal.value)
    assert "\n" not in str(refusal.value)


def test_a_damaged_catalogue_is_told_with_its_place(tmp_path):
    path = tmp_path / "messages.yaml"
    path.write_text("format: charger_messages/1\nassumed: true\nerrors: [{number: 1}]\n")
    with pytest.raises(UserError, match=r"yaml:3:10: 'key', 'emcy', 'register' are missing"):
        Bench("charger", messages=str(path))


def test_a_setting_that_is_refused_leaves_everything_as_it_was(on):
    on.set(load="resistor 20e6")
    with pytest.raises(UserError):
        on.set(load="resistor 0", ambient=10)
    on.run(0.1)
    assert (on.device.settings.ambient, value(on, 2, 0x6401)) == (25.0, 1000)
    assert status(on) == 0x29
