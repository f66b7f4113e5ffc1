"""Short forms of what runs for an hour: the commands in benchmarks/, with their invariants."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
SHORT = {
    "soak": "--seconds 1 --heartbeat 100",
    "crowd": "--clients 40 --seconds 1 --rate 300",
    "kills": "--kills 12",
}


@pytest.mark.parametrize("name", SHORT)
def test_every_invariant_holds_for_a_while(name):
    command = [sys.executable, "-m", f"benchmarks.{name}", *SHORT[name].split()]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.endswith("every invariant holds\n")
