"""campaign: a grid of runs, each played once, whoever plays it."""

import json
import os
import re
import signal
import sqlite3
import subprocess
import sys
import time
from contextlib import ExitStack, closing, contextmanager
from pathlib import Path

import pytest

from canopen_twins.cli import main
from canopen_twins.errors import UserError
from canopen_twins.hunt.campaign import lost
from canopen_twins.hunt.cluster import Cluster
from canopen_twins.hunt.results import Results

from .conftest import play_here
from .masters import BRITTLE, CAREFUL

CONTRACT = """\
version: 1
name: A supply is held at a voltage
node: {device: topcon, node_id: 5, settings: {load: resistor 4}}
duration: 1
recovers: {within: 3, when: {value: {Voltage reference: 2000}}}
steps: []
"""
CAMPAIGN = """\
version: 1
contract: contract.yaml
settings:
  load: [resistor 4, open]
  timing: [ideal, typical]
disturbances:
  - nothing
  - {at: 0.5, inject: {sdo_silence: {times: [1, 2]}}}
seeds: [1]
"""
RUNS = 2 * 2 * 3
EMPTY = 2 * 4096  # bytes of a file without runs


@pytest.fixture
def played_elsewhere(tmp_path, monkeypatch, capsys):
    """Play a campaign with a master in other processes; exit code and what is said."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "contract.yaml").write_text(CONTRACT)

    def played(master, *arguments, campaign=CAMPAIGN):
        (tmp_path / "my_master.py").write_text(master)
        (tmp_path / "campaign.yaml").write_text(campaign)
        code = main(["campaign", "campaign.yaml", "--master", "my_master:main", *arguments])
        said = capsys.readouterr()
        return code, said.out + said.err

    return played


@pytest.fixture
def played(here, played_elsewhere):
    """The same in this one."""
    return played_elsewhere


def test_every_run_of_the_grid_is_played_once_and_never_again(played):
    code, said = played(CAREFUL)
    assert code == 0
    assert f"{RUNS} runs" in said
    assert said.endswith(f"{RUNS} of {RUNS} played now\n")
    assert played(CAREFUL)[1].endswith(f"0 of {RUNS} played now\n")


def test_another_master_is_played_anew_and_what_fails_is_told_with_its_place_in_the_grid(
    played, tmp_path
):
    played(CAREFUL)
    code, said = played(BRITTLE, "--junit", "report.xml", "--html", "report.html")
    assert code == 1
    assert said.endswith(f"{RUNS} of {RUNS} played now\n")
    assert "SdoCommunicationError" in said
    assert "'sdo_silence': {'times': 1}" in said
    assert re.search(rf"^contract\.yaml: {RUNS} runs, [1-9]\d* failed, ", said, re.MULTILINE)
    assert f"{RUNS} runs, 8 failed, " in (tmp_path / "report.html").read_text()
    assert "<failure" in (tmp_path / "report.xml").read_text()
    assert "sdo_silence" in (tmp_path / "report.html").read_text()


def test_runs_that_say_nothing_and_faults_that_never_strike_are_told(played):
    lazy = "import asyncio\n\n\ndef main(network):\n    asyncio.run(None)\n"
    late = "version: 1\ncontract: contract.yaml\ndisturbances: [{at: 99, inject: power_cycle}]\n"
    code, said = played(lazy, campaign=late)
    assert code == 0
    assert "1 run, 0 failed, 1 said nothing (master my_master:main: asyncio" in said
    assert "    never struck: power_cycle\n" in said


def test_a_campaign_that_is_cut_short_goes_on_where_it_was(played, tmp_path):
    played(CAREFUL)
    with sqlite3.connect(tmp_path / "campaign.sqlite") as database:
        database.execute("DELETE FROM runs WHERE key IN (SELECT key FROM runs LIMIT 5)")
    database.close()
    assert played(CAREFUL)[1].endswith(f"5 of {RUNS} played now\n")


def test_two_processes_find_the_same_to_the_byte(played_elsewhere, tmp_path):
    with pytest.MonkeyPatch.context() as patch:
        play_here(patch)
        played_elsewhere(BRITTLE, "--json", "here.json")
    (tmp_path / "campaign.sqlite").unlink()
    played_elsewhere(BRITTLE, "--json", "there.json", "--jobs", "2")
    here = (tmp_path / "here.json").read_bytes()
    assert (tmp_path / "there.json").read_bytes() == here
    runs = json.loads(here)["runs"]
    assert len(runs) == RUNS
    assert {run["verdict"] for run in runs} == {"PASS", "FAIL"}
    assert runs[0]["settings"] == {"topcon.load": "resistor 4", "topcon.timing": "ideal"}


def test_a_file_of_results_belongs_to_one_campaign_at_a_time(tmp_path):
    path = tmp_path / "runs.sqlite"
    Results(path).__exit__()
    with Results(path) as mine:
        with pytest.raises(UserError, match=r"runs\.sqlite belongs to another run"):
            Results(path, patience=0.1)
        mine.keep("a", {})


def test_a_database_of_something_else_stays_as_it_is(played, tmp_path):
    path = tmp_path / "other.sqlite"
    for table in ("albums (title TEXT)", "runs (number INTEGER)"):
        path.unlink(missing_ok=True)
        with closing(sqlite3.connect(path)) as database:
            database.execute(f"CREATE TABLE {table}")
        before = path.read_bytes()
        code, said = played(CAREFUL, "--results", "other.sqlite")
        assert (code, path.read_bytes() == before) == (2, True)
        assert said.endswith("other.sqlite is a database of something else\n")


def test_a_run_that_cannot_be_read_any_more_is_damage(tmp_path):
    path = tmp_path / "runs.sqlite"
    with Results(path) as results:
        results.keep("a", {"error": "none"})
    path.write_bytes(path.read_bytes().replace(b'{"error"', b'{"error:'))
    with Results(path) as results:
        assert "was damaged" in results.told
        assert "a" not in results


@pytest.mark.skipif(sys.platform == "win32", reason="has no such limit")
def test_a_disk_that_is_full_is_one_line(tmp_path):
    import resource  # noqa: PLC0415

    with Results(tmp_path / "runs.sqlite") as results:
        before = resource.getrlimit(resource.RLIMIT_FSIZE)
        resource.setrlimit(resource.RLIMIT_FSIZE, (64 << 10, before[1]))
        try:
            with pytest.raises(UserError, match=r"runs\.sqlite cannot be written: "):
                results.keep("a", {"error": "x" * (1 << 20)})
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, before)


def test_where_no_file_of_results_can_be_is_one_line(played):
    code, said = played(CAREFUL, "--results", "/proc/runs.sqlite")
    assert (code, said.count("\n")) == (2, 1)
    assert "/proc/runs.sqlite cannot be opened: unable to open database file" in said


def test_a_damaged_file_of_results_is_kept_aside(played, tmp_path):
    (tmp_path / "campaign.sqlite").write_bytes(b"no database, but a text" * 100)
    code, said = played(CAREFUL)
    assert code == 0
    assert "was damaged" in said
    assert (tmp_path / "campaign.sqlite.bad").read_bytes().startswith(b"no database")


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("contract: missing.yaml", "campaign.yaml:2:11: there is no file missing.yaml"),
        ("contract: contract.yaml\nsettings: {lod: [open]}", "3:12: "),
        ("contract: contract.yaml\nsettings: {load: [a brick]}", "3:12: setting 'load': no load"),
        ("contract: contract.yaml\nsettings: {five.load: [open]}", "3:12: unknown node 'five'"),
        ("contract: contract.yaml\ndevices: [topcom]", "3:11: "),
        ("contract: contract.yaml\ndisturbances: [{at: 1, inject: no_such}]", "3:16: "),
        (
            "contract: contract.yaml\ndisturbances: [{at: 1, inject: {sdo_silence: {times: []}}}]",
            "3:16: an empty list: there has to be a value to be played with",
        ),
        ("contract: contract.yaml\ndisturbances: [everything]", "3:16: 'everything': wanted is"),
        ("contract: contract.yaml\nseeds: 0", "3:8: 0 is not in 1..100000"),
        ("contract: contract.yaml\nseeds: [1, 2, 1]", "3:8: 1 stands there twice: a run is"),
        (
            "contract: contract.yaml\nsettings: {load: [open, open]}",
            "3:25: open stands there twice",
        ),
        ("contract: contract.yaml\ndevices: [topcon, topcon]", "3:19: topcon stands there twice"),
        (
            "contract: contract.yaml\ndisturbances: [{at: [1, 1], inject: sdo_silence}]",
            "3:15: {'at': 1, 'inject': 'sdo_silence'} stands there twice",
        ),
        ("seeds: 3", "'contract' is missing"),
    ],
)
def test_what_is_wrong_with_a_campaign_is_told_with_its_place(played, text, told):
    code, said = played(CAREFUL, campaign=f"version: 1\n{text}\n")
    assert code == 2
    assert told in said


@contextmanager
def a_cluster(folder):
    """A scheduler of dask on loopback with two workers; its address, the workers, and it."""
    with ExitStack() as ended:
        file = folder / "scheduler.json"

        def start(*words):
            log = ended.enter_context((folder / f"log-{len(list(folder.iterdir()))}").open("w"))
            process = subprocess.Popen(
                [sys.executable, "-m", "distributed.cli.dask_" + words[0], *words[1:]],
                stdout=log,
                stderr=log,
                cwd=folder,
                env={**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))},
            )
            ended.callback(process.wait)
            ended.callback(process.terminate)
            return process

        address = ("--host", "127.0.0.1")
        words = ("--port", "0", "--no-dashboard", "--scheduler-file", str(file))
        scheduler = start("scheduler", *address, *words)
        until(lambda: file.exists() and file.read_text().endswith("}"))  # not in the middle of it
        address = json.loads(file.read_text())["address"]
        once = ("--nthreads", "1", "--no-nanny", "--no-dashboard", "--host", "127.0.0.1")
        yield address, [start("worker", address, *once) for _ in range(2)], scheduler


def size(path):
    return path.stat().st_size if path.exists() else 0


def until(true):
    end = time.monotonic() + 60
    while not true():
        assert time.monotonic() < end
        time.sleep(0.05)


@pytest.mark.timeout(300)
def test_a_cluster_finds_the_same_to_the_byte_though_one_of_it_is_killed_and_its_end_is_one_line(
    played, tmp_path
):
    pytest.importorskip("distributed")
    long = CAMPAIGN.replace("seeds: [1]", "seeds: 3")
    played(BRITTLE, "--json", "here.json", campaign=long)
    (tmp_path / "campaign.sqlite").unlink()
    work = tmp_path / "cluster"
    work.mkdir()
    with a_cluster(work) as (address, workers, scheduler):
        command = ["campaign", "campaign.yaml", "--master", "my_master:main", "--dask", address]
        command += ["--upload", "my_master.py", "--json", "there.json"]
        playing = subprocess.Popen(
            [sys.executable, "-m", "canopen_twins", *command],
            cwd=tmp_path,
            env={**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))},
        )
        until(lambda: size(tmp_path / "campaign.sqlite") > EMPTY)
        workers[0].send_signal(signal.SIGKILL)
        assert playing.wait(240) == 1
        with Cluster(address, lost) as cluster:
            played = cluster(str, range(1000))
            assert next(played) == "0"
            scheduler.send_signal(signal.SIGKILL)
            with pytest.raises(UserError, match=f"^the dask scheduler at {address} is gone: "):
                list(played)
    assert (tmp_path / "there.json").read_bytes() == (tmp_path / "here.json").read_bytes()


def test_a_cluster_that_is_not_there_is_one_line(played, monkeypatch):
    pytest.importorskip("distributed")
    monkeypatch.setattr("canopen_twins.hunt.cluster.CONNECTING", 0.5)
    code, said = played(CAREFUL, "--dask", "tcp://127.0.0.1:9")
    assert code == 2
    assert said.startswith("canopen-twin: no dask scheduler at tcp://127.0.0.1:9")
    assert said.count("\n") == 1


def test_uploads_are_for_a_cluster(played):
    code, said = played(CAREFUL, "--upload", str(Path("my_master.py")))
    assert (code, "--upload goes with --dask" in said) == (2, True)
