from collections.abc import Callable
from dataclasses import asdict, replace

import pytest
import yaml

from canopen_twins import Bench
from canopen_twins.devices.topcon.model.loads import parse_load
from canopen_twins.devices.topcon.model.stage import OutputStage
from canopen_twins.devices.topcon.model.unit import UnitType
from canopen_twins.devices.topcon.unit_file import read_unit_types
from canopen_twins.files.shipped import od_file


@pytest.fixture
def topcon() -> Bench:
    """A TopCon with power on and nothing connected, node id 5; its boot-up message is out."""
    return Bench("topcon", node_id=5)


@pytest.fixture
def unit_file(units, tmp_path) -> Callable[..., str]:
    """A file with one unit type "MINE": the shipped TCP-32-400 with other figures."""

    def unit_file(**figures) -> str:
        mine = {**asdict(units["TCP-32-400"]), "name": "MINE", **figures}
        path = tmp_path / "units.yaml"
        path.write_text(yaml.safe_dump({"version": 1, "types": [mine]}))
        return str(path)

    return unit_file


@pytest.fixture(scope="session")
def units() -> dict[str, UnitType]:
    with od_file("topcon_units.yaml") as path:
        return read_unit_types(path)


@pytest.fixture
def power_on(units) -> Callable[..., OutputStage]:
    """A stage just powered; `parts` are 0x2010-0x2013 as a master would write them."""

    def power_on(
        name="TCP-32-400",
        load="open",
        parts=(0, 0, 4000, 0),
        figures=(),
        kind=OutputStage,
        **inputs,
    ):
        unit = replace(units[name], **dict(figures))
        stage = kind(unit, load=parse_load(load), **inputs)
        voltage, current, power, resistance = (part / 4000 for part in parts)
        stage.voltage_reference = voltage * stage.unit.nominal_voltage
        stage.current_reference = current * stage.unit.maximum_current
        stage.power_reference = power * stage.unit.nominal_power
        stage.resistance_reference = resistance * stage.unit.nominal_resistance
        return stage

    return power_on


@pytest.fixture
def running(power_on) -> Callable[..., OutputStage]:
    """The same, three seconds after a RUN command."""

    def running(*args, **inputs):
        stage = power_on(*args, **inputs)
        stage.run()
        stage.step(3.0)
        return stage

    return running
