"""An EDS file as the standard wants it, and what tools make of one."""

from pathlib import Path

import pytest

from canopen_twins.slave.eds.reader import read_eds
from canopen_twins.slave.object import entries_of

FILES = Path(__file__).parent / "files"
BASE = (FILES / "00_base.eds").read_text("ascii")


class Reading:
    """What has been read: entries by address, and the remarks."""

    def __init__(self, path, **options):
        self.eds = read_eds(path, **options)
        self.remarks = [remark.told(path.name) for remark in self.eds.remarks]

    def __getitem__(self, address):
        index, subindex = address
        return entries_of(self.eds.dictionary.indices[index])[subindex]

    def __contains__(self, address):
        index, subindex = address
        item = self.eds.dictionary.indices.get(index)
        return item is not None and subindex in entries_of(item)

    def value(self, index, subindex=0):
        """ParameterValue or DefaultValue."""
        variable = self[index, subindex]
        return variable.default if variable.value is None else variable.value


@pytest.fixture
def read():
    """Reads one of the files."""
    return lambda name, **options: Reading(FILES / name, **options)


@pytest.fixture
def reading(tmp_path):
    """Reads the base file with sections behind it, or with a piece of it changed."""

    def make(more="", old="", new="", name="drive.eds", encoding="utf-8", **options):
        assert not old or old in BASE
        path = tmp_path / name
        path.write_bytes((BASE.replace(old, new) + more).encode(encoding))
        return Reading(path, **options)

    return make


def entry(index, data_type, default, more=""):
    """A section of one variable."""
    return (
        f"[{index:04X}]\nParameterName=Extra\nObjectType=0x7\nDataType=0x{data_type:04X}\n"
        f"AccessType=rw\nDefaultValue={default}\nPDOMapping=0\n{more}\n"
    )
