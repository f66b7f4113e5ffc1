"""Whatever becomes of a file: it is a dictionary, or it is refused in one line."""

import random
import time
from contextlib import suppress

import pytest
from hypothesis import given
from hypothesis import strategies as st

from canopen_twins import Bench
from canopen_twins.errors import UserError
from canopen_twins.slave.eds.reader import read_eds

from .conftest import FILES

SOURCES = [path.read_bytes() for path in sorted(FILES.iterdir())]
PATIENCE = 30.0  # seconds for a file; the slowest takes some milliseconds


def mutated(seed):
    """A file with lines dropped, doubled and swapped, and bytes that are others."""
    dice = random.Random(seed)
    lines = dice.choice(SOURCES).splitlines(keepends=True)
    for _ in range(dice.randrange(1, 20)):
        place, other = dice.randrange(len(lines)), dice.randrange(len(lines))
        match dice.randrange(4):
            case 0:
                lines[place] = b""
            case 1:
                lines.insert(place, lines[other])
            case 2:
                lines[place], lines[other] = lines[other], lines[place]
            case _:
                line = bytearray(lines[place] or b"x")
                line[dice.randrange(len(line))] = dice.randrange(256)
                lines[place] = bytes(line)
    return b"".join(lines)


def read(path, content):
    path.write_bytes(content)
    begun = time.monotonic()
    told = ""
    try:
        read_eds(path)
    except UserError as refusal:
        told = str(refusal)
    assert "\n" not in told
    assert time.monotonic() - begun < PATIENCE


@pytest.mark.parametrize("block", range(20))
def test_a_file_that_was_tampered_with_is_read_or_refused(tmp_path, block):
    for seed in range(block * 100, block * 100 + 100):
        read(tmp_path / "drive.eds", mutated(seed))


@pytest.mark.parametrize("seed", [*range(0, 2000, 20), 2108, 5558])
def test_a_twin_of_a_file_that_was_tampered_with_lives_or_is_refused(tmp_path, seed):
    path = tmp_path / "drive.eds"
    path.write_bytes(mutated(seed))
    with suppress(UserError):
        bench = Bench(path, node_id=5)
        for frame in ("000#0105", "080#", "605#4000100000000000", "705#R", "205#0700"):
            bench.send(frame)
        bench.run(0.3)


@given(st.binary(max_size=400))
def test_any_bytes_are_read_or_refused(tmp_path_factory, content):
    read(tmp_path_factory.getbasetemp() / "any.eds", content)


KEYS = ("ObjectType", "DataType", "DefaultValue", "LowLimit", "SubNumber", "CompactSubObj")


@given(st.dictionaries(st.sampled_from(KEYS), st.text(max_size=30)))
def test_any_words_behind_the_keys_of_an_object_are_read_or_refused(tmp_path_factory, keys):
    lines = "\n".join(f"{key}={text}" for key, text in keys.items())
    content = f"[1000]\nParameterName=x\nDataType=7\n[2000]\n{lines}\n".encode("utf-8", "ignore")
    read(tmp_path_factory.getbasetemp() / "any.eds", content)
