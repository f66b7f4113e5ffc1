"""A pytest session of two tests, as a user writes them, that pauses before and after one stage.

A pause says `done` on stdout and goes on with the next line of stdin: see `test_ready.fresh`.
"""

import os
import sys
from collections.abc import Generator
from typing import Any

import pytest

ACTUAL_VOLTAGE = 0x2020
OPTIONS = (
    __file__,
    "-c",
    os.devnull,
    "--capture=no",
    "-p",
    "no:terminal",
    "-p",
    "no:cacheprovider",
)


@pytest.fixture
def voltage(canopen_bench: Any) -> bytes:
    """A device is ready when it has answered; this one has a node id of its own."""
    answer: bytes = canopen_bench("topcon", node_id=5).sdo.upload(ACTUAL_VOLTAGE, 0)
    return answer


@pytest.mark.parametrize("number", ["first", "later"])
def test(voltage: bytes, number: str):
    assert voltage == bytes(2)


def run(stage: str) -> None:
    """Stages: the end of the `collection`, and the set-up of the `first` and the `later` test."""
    pytest.main([*OPTIONS], plugins=[Pauses(stage)])
    raise SystemExit("whoever waits at a pause ends this process")


class Pauses:
    """Stands around the hooks of everybody else."""

    def __init__(self, stage: str) -> None:
        self._stage = stage

    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_collection_finish(self) -> Generator[None, object, object]:
        return (yield from self._between("collection"))

    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_runtest_setup(self, item: pytest.Item) -> Generator[None, object, object]:
        return (yield from self._between(item.name.removeprefix("test[").removesuffix("]")))

    def _between(self, stage: str) -> Generator[None, object, object]:
        if stage != self._stage:
            return (yield)
        _pause()
        result = yield
        _pause()
        return result


def _pause() -> None:
    print("done", flush=True)
    sys.stdin.readline()
