"""Sections of PDOs for the file of a device, and what comes of frames."""

from .declared import U32, entry, record


def mappable(*arguments):
    """A section of an entry that PDOs may carry."""
    return entry(*arguments).replace("PDOMapping=0", "PDOMapping=1")


def mapping(index, *parts):
    """A record that maps parts, and can be changed."""
    fixed = record(index, *((U32, f"0x{part:08X}") for part in parts))
    return fixed.replace("AccessType=const", "AccessType=rw")


def news(bench, *frames):
    """What comes of some frames, but for the answers to SDO requests."""
    sent = [answer for frame in frames for answer in bench.send(frame)]
    return [answer for answer in sent if not answer.startswith("585")]
