"""From nothing to the first answer: imports, the first twin of a process, every later one."""

import os
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping
from itertools import count
from pathlib import Path

import pytest
from pytest_benchmark.fixture import BenchmarkFixture

from benchmarks import peers
from canopen_twins import Bench

ROOT = Path(__file__).parent.parent
LISTEN = "import sys\nfor line in sys.stdin: exec(line); print('done', flush=True)"
TWIN = "from canopen_twins import Bench; Bench('topcon', node_id=5).sdo.upload(0x2020, 0)"
TWINS = ("-m", "canopen_twins")
LOCAL_NODE = "pair = peers.virtual('first'); pair.__enter__().sdo.upload(0x2020, 0)"

Environment = Mapping[str, str]
Fresh = Callable[[str], Callable[[str], None]]


@pytest.fixture
def environment(tmp_path_factory: pytest.TempPathFactory) -> Environment:
    """Bytecode is cached, as usual."""
    cache = tmp_path_factory.getbasetemp() / "bytecode"
    environment = {**os.environ, "PYTHONPYCACHEPREFIX": str(cache)}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    return environment


@pytest.fixture
def fresh(environment: Environment) -> Iterator[Fresh]:
    """Interpreters that have run one line and wait for the next."""
    started: list[subprocess.Popen[str]] = []

    def fresh(line: str) -> Callable[[str], None]:
        process = subprocess.Popen(
            [sys.executable, "-c", LISTEN],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            cwd=ROOT,
            env=environment,
        )
        started.append(process)

        def run(line: str) -> None:
            assert process.stdin
            assert process.stdout
            print(line, file=process.stdin, flush=True)
            assert process.stdout.readline() == "done\n"

        run(line)
        return run

    yield fresh
    for process in started:
        process.kill()
        process.communicate()


@pytest.mark.parametrize(
    ("before", "line"),
    [
        pytest.param("import pytest", "import canopen", id="import-canopen"),
        pytest.param("import pytest", "import canopen_twins", id="import-canopen_twins"),
        pytest.param("import pytest", "import canopen_twins.pytest_plugin", id="import-plugin"),
        pytest.param("import pytest", "from canopen_twins import Bench", id="import-bench"),
        pytest.param("import canopen", TWIN, id="first-twin"),
        pytest.param("from benchmarks import peers", LOCAL_NODE, id="first-localnode"),
    ],
)
def test_fresh(benchmark: BenchmarkFixture, fresh: Fresh, before: str, line: str):
    """In a process that has done nothing but one thing."""
    benchmark.pedantic(
        lambda run: run(line),
        setup=lambda: ((fresh(before),), {}),
        rounds=9,
        warmup_rounds=1,
    )


@pytest.mark.parametrize("stage", ["collection", "first", "later"])
def test_session(benchmark: BenchmarkFixture, fresh: Fresh, stage: str):
    """What a test with the fixture `canopen_bench` waits for, until a twin has answered it."""
    line = f"from benchmarks import session; session.run({stage!r})"
    benchmark.pedantic(
        lambda go_on: go_on(""), setup=lambda: ((fresh(line),), {}), rounds=9, warmup_rounds=1
    )


@pytest.mark.parametrize("fixture", ["topcon", "request"])
def test_process(
    benchmark: BenchmarkFixture, environment: Environment, tmp_path: Path, fixture: str
):
    """A run of one test with a twin or with nothing, process start included."""
    (tmp_path / "test_one.py").write_text(f"def test_one({fixture}): pass")
    command = [sys.executable, "-m", "pytest", "-q", "-c", os.devnull, str(tmp_path)]
    benchmark.pedantic(
        lambda: subprocess.run(
            command, cwd=ROOT, env=environment, check=True, stdout=subprocess.DEVNULL
        ),
        rounds=5,
        warmup_rounds=1,
    )


@pytest.mark.parametrize(
    "command",
    [
        pytest.param(["-c", "import canopen; print()"], id="canopen"),
        pytest.param([*TWINS, "run", "topcon", "-i", "virtual", "-c", "ready"], id="run"),
        pytest.param([*TWINS, "play", "topcon_overvoltage.yaml"], id="play"),
    ],
)
def test_first_line(benchmark: BenchmarkFixture, environment: Environment, command: list[str]):
    """From the start of a process to what it says first."""
    started: list[subprocess.Popen[bytes]] = []

    def start() -> None:
        process = subprocess.Popen(
            [sys.executable, *command], cwd=ROOT, env=environment, stdout=subprocess.PIPE
        )
        started.append(process)
        assert process.stdout
        assert process.stdout.readline()

    def end() -> None:
        while started:
            process = started.pop()
            process.kill()
            process.communicate()

    benchmark.pedantic(start, setup=end, rounds=7, warmup_rounds=1)
    end()


def test_later_twin(benchmark: BenchmarkFixture):
    """As a fixture makes one for each test."""
    benchmark(lambda: Bench("topcon", node_id=5).sdo.upload(peers.ACTUAL_VOLTAGE, 0))


def test_later_localnode(benchmark: BenchmarkFixture):
    """Two networks on `virtual`; their shut-down, a second each, is not counted."""
    opened, channel = [], count()

    def connect() -> None:
        pair = peers.virtual(f"later-{next(channel)}")
        pair.__enter__().sdo.upload(peers.ACTUAL_VOLTAGE, 0)
        opened.append(pair)

    benchmark.pedantic(connect, rounds=7, warmup_rounds=1)
    for pair in opened:
        pair.__exit__(None, None, None)
