"""At which SDO requests a fault aims: an object, reading or writing, the initiate or a segment."""

import re
from collections.abc import Mapping
from dataclasses import dataclass

from canopen import ObjectDictionary
from canopen.objectdictionary import ODVariable

from simulators.errors import UserError, unknown
from simulators.faults import Parameter
from simulators.mischief.conversation import READ, WRITE, Conversation

ANY = "any"
ACCESSES = (READ, WRITE, ANY)
ADDRESS = re.compile(r"0x([0-9A-Fa-f]{4})(?::([0-9A-Fa-f]{2}))?")
LARGEST_INDEX = 0xFFFF

OBJECT = {"object": Parameter("0x2014, 0x1018:02, its name in the EDS, or any", ANY, object)}
ACCESS = {"access": Parameter("read, write or any", ANY, str)}
SEGMENT = {"segment": Parameter("0: the initiate; n: the n-th request after it", 0, int, low=0)}


@dataclass(frozen=True)
class Aim:
    """What is None may be anything."""

    index: int | None
    subindex: int | None
    access: str | None
    segment: int

    @classmethod
    def at(cls, od: ObjectDictionary, object: int | str, access: str, segment: int) -> "Aim":
        """What the parameters of a fault say.

        Raises:
            UserError: no such object, no such access.
        """
        if access not in ACCESSES:
            raise unknown("access", access, ACCESSES)
        return cls(*_address(od, object), None if access == ANY else access, segment)

    def hits(self, conversation: Conversation) -> bool:
        """Whether the request that came last is meant."""
        if conversation.address is None or conversation.segment != self.segment:
            return False
        found = (*conversation.address, conversation.access)
        wanted = (self.index, self.subindex, self.access)
        return all(one in (None, other) for one, other in zip(wanted, found, strict=True))


def _address(od: ObjectDictionary, object: int | str) -> tuple[int | None, int | None]:
    if object == ANY:
        return None, None
    if isinstance(object, int):
        if not 0 <= object <= LARGEST_INDEX:
            raise UserError(f"{object:#x} is no index; indices are 0x0000..0xffff")
        return object, None
    if match := ADDRESS.fullmatch(object):
        return int(match[1], 16), int(match[2], 16) if match[2] else None
    names = _names(od)
    if object not in names:
        raise unknown("object", object, names)
    return names[object]


def _names(od: ObjectDictionary) -> Mapping[str, tuple[int, int | None]]:
    names: dict[str, tuple[int, int | None]] = {}
    for name, item in od.names.items():
        names[name] = (item.index, None)
        if not isinstance(item, ODVariable):
            parts = item.subindices.values()
            names |= {f"{name}.{part.name}": (part.index, part.subindex) for part in parts}
    return names
