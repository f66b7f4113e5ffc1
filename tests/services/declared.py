"""Twins of files that declare a service: the base file of tests/eds with sections behind it."""

from pathlib import Path

from canopen_twins import Bench

BASE = (Path(__file__).parent.parent / "eds" / "files" / "00_base.eds").read_text("ascii")
U8, U16, U32 = 5, 6, 7
BOOLEAN, REAL32, TEXT, OCTETS, TIME, DIFFERENCE, DOMAIN, U64 = 1, 8, 9, 0xA, 0xC, 0xD, 0xF, 0x1B


def entry(address, data_type, default="", access="rw", more=""):
    """A section: 1017 is a variable, 1201sub1 a part of a record."""
    kind = "0x2" if data_type == DOMAIN else "0x7"
    return (
        f"[{address}]\nParameterName=Entry {address}\nObjectType={kind}\n"
        f"DataType=0x{data_type:04X}\nAccessType={access}\nDefaultValue={default}\n"
        f"PDOMapping=0\n{more}\n"
    )


def record(index, *subs):
    """A record, given type, default and access of its sub-indices from 1 on."""
    text = f"[{index}]\nParameterName=Record {index}\nObjectType=0x9\nSubNumber={len(subs) + 1}\n"
    text += entry(f"{index}sub0", U8, len(subs), "const")
    return text + "".join(entry(f"{index}sub{n}", *sub) for n, sub in enumerate(subs, 1))


def bench_of(folder, more="", old="", new="", node_id=5, **settings):
    """A bench with the twin of such a file; without a node id with the one of the file."""
    assert not old or old in BASE
    path = folder / "drive.eds"
    path.write_text(BASE.replace(old, new) + more, "ascii")
    given = settings if node_id is None else {"node_id": node_id, **settings}
    return Bench(str(path), **given)
