import subprocess
import sys

import pytest

from canopen_twins import Bench
from canopen_twins.devices.topcon.model.stage import OutputStage
from canopen_twins.scenario import load, play

SCENARIO = """
version: 1
name: A run
note: Of one device.
node: {device: topcon, node_id: 5}
steps:
  - {at: 1, nmt: start}
"""
FILES_OF_OD = """
import sys
opened = []
sys.addaudithook(lambda event, given: event == "open" and opened.append(str(given[0])))
import canopen_twins.devices.topcon
print(*(path for path in opened if "/od/" in path))
"""


@pytest.fixture
def built(monkeypatch):
    """Every output stage that is made."""
    stages = []
    make = OutputStage.__post_init__

    def made(stage):
        stages.append(stage)
        make(stage)

    monkeypatch.setattr(OutputStage, "__post_init__", made)
    return stages


def test_a_bench_builds_the_output_stage_once_for_each_power_on(built):
    bench = Bench("topcon", node_id=5)
    assert built == [bench.device.stage]
    bench.power_off()
    bench.power_on(load="short")
    assert built[1:] == [bench.device.stage]


def test_a_scenario_is_played_with_one_output_stage(built, tmp_path):
    path = tmp_path / "run.yaml"
    path.write_text(SCENARIO)
    scenario = load(path)
    built.clear()
    assert play(scenario).ok
    assert len(built) == 1


def test_importing_the_device_reads_no_file_of_od():
    command = [sys.executable, "-c", FILES_OF_OD]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert done.stdout.split() == []
