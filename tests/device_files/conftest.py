import shutil
from pathlib import Path

import pytest

from canopen_twins import Bench

EXAMPLES = Path(__file__).parents[2] / "docs" / "examples"


@pytest.fixture
def write(tmp_path):
    """Writes a device file of the battery's EDS, and what else is told."""
    shutil.copy(EXAMPLES / "battery" / "battery.eds", tmp_path)

    def write(text, name="battery.device.yaml"):
        path = tmp_path / name
        path.write_text(f"version: 1\neds: battery.eds\n{text}\n")
        return path

    return write


@pytest.fixture
def bench(write):
    """A bench with the device of such a text as node 5."""

    def bench(text, **settings):
        return Bench(str(write(text)), node_id=5, **settings)

    return bench
