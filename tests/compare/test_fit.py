import re

import pytest
import yaml

from canopen_twins import Bench, devices

from .conftest import log, traced
from .local_node import BLOCK
from .masters import Master, charging, measuring, supply, too_high


@pytest.fixture
def fitted(field, said, tmp_path):
    """The settings that are found for a device with others, and how much they are worth."""

    def fit(master=supply, **settings):
        trace = field(master, **settings)
        code, _, err = said("compare", "topcon", "-n", "5", trace, "--fit", tmp_path / "fit.yaml")
        assert code == 1
        after, before = map(float, re.findall(r"([\d.]+) %", err))
        found = yaml.safe_load((tmp_path / "fit.yaml").read_text())
        assert said("compare", tmp_path / "fit.yaml", trace)[0] == (0 if after == 100 else 1)
        return found["nodes"]["topcon"].get("settings", {}), before, after

    return fit


def test_settings_and_times_that_a_trace_decides_are_found(fitted):
    given = {
        "serial": 77,
        "firmware": "V4.11.20",
        "hb_first": "now",
        "empty_1003": "abort",
        "strict_cobid": True,
        "run_while_error": "abort",
        "on_leave_operational": "stop",
        "power_on_voltage": 7,
        "ovp_when_off": False,
    }
    times = {"boot_time": 0.4, "answer_time": 0.02, "answer_jitter": 0.01, "store_time": 0.3}
    found, before, after = fitted(**given, **times)
    assert before < after == 100
    assert found.items() >= given.items()
    for name, value in times.items():
        assert found[name] == pytest.approx(value, abs=0.005)


def test_noise_is_what_the_values_show(fitted):
    found, before, after = fitted(measuring, noise=3)
    assert before < after == 100
    assert found["noise"] == pytest.approx(3, abs=1)


def test_a_device_under_another_load_is_not_explained_by_noise(fitted):
    found, _, _ = fitted(measuring, load="resistor 4")
    assert "noise" not in found


def test_what_nothing_can_be_set_for_stays_as_it_is(fitted):
    found, before, after = fitted(too_high, set_value_range=32767)
    assert (set(found.values()), before) == ({0.0}, after)


def test_a_file_is_refused_by_its_name(field, said, tmp_path):
    trace = field(too_high)
    code, _, err = said("compare", "topcon", "-n", "5", trace, "--fit", tmp_path / "fit.txt")
    assert (code, err.count("\n")) == (2, 1)
    assert "the name of a bench file ends in .yaml, not in .device.yaml" in err


def test_a_setting_that_shows_only_after_another_is_found(said, tmp_path):
    given = {"kind": "PCMT", "heartbeat_default_ms": 2000, "heartbeat_step": "floor"}
    trace = log(tmp_path / "field.log", traced(charging, "charger", **given))
    said("compare", "charger", "-n", "5", trace, "--fit", tmp_path / "fit.yaml")
    found = yaml.safe_load((tmp_path / "fit.yaml").read_text())["nodes"]["charger"]["settings"]
    assert found.items() >= given.items()
    assert said("compare", tmp_path / "fit.yaml", trace)[0] == 0


def block(bench):
    """A master of an I/O block: who it is, its inputs by SDO and by PDO."""
    master = Master(bench)
    bench.run(0.01)
    master.read((0x1000, 0), (0x1018, 1), (0x1018, 2), (0x6200, 1), (0x1017, 0))
    master.nmt(0x01)
    for step in range(30):
        bench.set(**{"0x6401:01": 200 + step, "0x6401:02": 1000 - 3 * step})
        master.run(0.1)
        master.send(0x280, "R")
    master.read((0x6000, 1))


def test_the_twin_of_a_file_gets_the_values_of_the_device(said, tmp_path):
    text = BLOCK.read_text()
    other = tmp_path / "other.eds"
    other.write_text(text.replace("DefaultValue=0x00000002", "DefaultValue=0x00000BAD"))
    assert other.read_text() != text
    trace = log(tmp_path / "field.log", traced(block, str(other)))
    code, out, err = said("compare", BLOCK, "-n", "5", trace, "--fit", tmp_path / "fit.yaml")
    assert (code, "TPDO2 0x6401:01" in out, "0x1018:02" in out) == (1, True, True)
    assert "fit_io_block.device.yaml" in err
    after, before = map(float, re.findall(r"([\d.]+) %", err))
    assert after > before
    assert devices.create(str(tmp_path / "fit_io_block.device.yaml")).files
    bench = Bench(str(tmp_path / "fit_io_block.device.yaml"), node_id=5)
    assert bench.values("0x1018:02") == {"0x1018:02": 0xBAD}
    bench.run(2)
    assert 215 <= bench.values("0x6401:01")["0x6401:01"] <= 225
    _, out, _ = said("compare", tmp_path / "fit.yaml", trace)
    assert out.splitlines()[0].startswith(f"{after:g} %")
