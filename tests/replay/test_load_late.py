import signal
import subprocess
import sys

from .conftest import HEAD

LATE = "pydantic"
PYTHON = [sys.executable, "-X", "importtime"]
MASTER = """\
def test_it(canopen_bench):
    canopen_bench("topcon", node_id=5).run(0.1)
    canopen_bench("gateway", config="gateway_plain.yaml").run(0.1)
"""


def imported(*command):
    """Whether a program imports it."""
    done = subprocess.run([*PYTHON, *command], capture_output=True, text=True, check=True)
    return LATE in done.stderr


COMMANDS = """\
from canopen_twins.cli import main
for words in "list", "faults topcon", "settings gateway":
    assert main(words.split()) == 0
main(["run", "--help"])
"""


def test_commands_that_read_no_scenario_do_without():
    assert not imported("-c", COMMANDS)


def test_a_run_without_a_scenario_does_without():
    command = [*PYTHON, "-m", "canopen_twins", "run", "topcon", "-i", "virtual"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as run:
        run.stdout.readline()
        run.send_signal(signal.SIGTERM)
        _, err = run.communicate(timeout=60)
    assert run.returncode == 0
    told = err.decode()
    assert "canopen_twins.live" in told
    assert {LATE, "canopen_twins.scenario", "canopen_twins.bench"} & set(told.split()) == set()


def test_the_fixtures_do_without(tmp_path):
    (tmp_path / "test_master.py").write_text(MASTER)
    assert not imported("-m", "pytest", "-q", "-p", "no:cacheprovider", tmp_path)


def test_who_reads_a_scenario_or_asks_for_its_schema_does_not(tmp_path):
    (tmp_path / "story.yaml").write_text(HEAD.replace("probe", "topcon") + "- {at: 0, nmt: start}")
    assert imported("-m", "canopen_twins", "check", tmp_path / "story.yaml")
    assert imported("-m", "canopen_twins", "schema")
