"""What a hub and its clients say to each other, the protocol of socketcand, and where a hub is."""

import re
from collections.abc import Iterable, Iterator
from ipaddress import ip_address
from typing import NamedTuple

from canopen_twins.bus.frame import Frame
from canopen_twins.bus.identifiers import NODE_IDS, Cob, classify
from canopen_twins.errors import UserError

LOOPBACK, PORT = "127.0.0.1", 29536  # the port of socketcand


class HubAddress(NamedTuple):
    """A host by its name or number, and a TCP port."""

    host: str = LOOPBACK
    port: int = PORT

    @classmethod
    def parse(cls, text: str, port: int = PORT) -> "HubAddress":
        """Read HOST:PORT, where either may be left out; numbers of IPv6 stand in brackets.

        Args:
            text: What is to be read.
            port: The one that is meant where none is told.

        Raises:
            UserError: the text is no address.
        """
        match = re.fullmatch(
            r"(?P<host>\[[0-9A-Fa-f:.]+\]|[^:\[\]]*)(:(?P<port>[0-9]{1,5}))?", text
        )
        if not match or int(match["port"] or 0) > 0xFFFF:
            raise UserError(f"{text!r} is no address: write HOST:PORT, such as {cls()}")
        told = port if match["port"] is None else int(match["port"])
        return cls(match["host"].strip("[]") or LOOPBACK, told)

    @property
    def is_loopback(self) -> bool:
        """Whether nobody outside this machine, or this container, is reached there."""
        try:
            return ip_address(self.host).is_loopback
        except ValueError:
            return self.host == "localhost"

    def __str__(self) -> str:
        return f"[{self.host}]:{self.port}" if ":" in self.host else f"{self.host}:{self.port}"


LONGEST = 128  # bytes of an element; a frame has 60 at most
SEND = re.compile(r"send (?P<id>[0-9A-Fa-f]{1,8}) (?P<length>[0-8])(?P<data>( [0-9A-Fa-f]{1,2})*)")
SEND_REMOTE = re.compile(r"sendrtr (?P<id>[0-9A-Fa-f]{1,8}) [0-8]")
FRAME = re.compile(r"frame (?P<id>[0-9A-Fa-f]{3,8}) [0-9.]+(?P<data>( ?[0-9A-Fa-f]{2}){0,8})")
REMOTE = re.compile(r"rtr (?P<id>[0-9A-Fa-f]{3,8}) [0-9.]+ [0-8]")

OWN = re.compile(r"own (?P<ids>[0-9A-F]{32})")
UNKNOWN = "error unknown command"
"""What a socketcand says to a word that is not its own, such as `own`."""

ASKED_FOR = (Cob.TPDO, Cob.HEARTBEAT)  # by remote frames; with that of heartbeats: node guarding


class Refused(ValueError):  # noqa: N818 - of the client, not an error of ours
    """What was said is no protocol, or not what the bus can do."""


class Stream:
    """Takes bytes as they come and gives whole elements."""

    def __init__(self) -> None:
        self._rest = b""

    def feed(self, data: bytes) -> Iterator[str]:
        """The elements that are complete by now, without brackets, words one space apart.

        Raises:
            Refused: something stands between two elements, or one is too long or no ASCII text.
        """
        *whole, self._rest = (self._rest + data).split(b">")
        for part in whole:
            yield _text(part)
        if self._rest.strip():
            _text(self._rest)
        elif len(self._rest) > LONGEST:
            raise Refused(f"more than {LONGEST} bytes and no end")


def _text(part: bytes) -> str:
    if len(part) > LONGEST:  # before anything is done with it: blanks without end are refused, too
        raise Refused(f"more than {LONGEST} bytes and no end")
    part = part.strip()
    if not part.startswith(b"<") or b"<" in part[1:] or not part.isascii():
        raise Refused("this is the protocol of socketcand")
    return " ".join(part[1:].decode("ascii").split())


def element(text: str) -> bytes:
    """What goes over the connection."""
    return f"< {text} >".encode("ascii")


def sent(frame: Frame) -> bytes:
    """A frame on its way to the hub."""
    if frame.remote:
        return element(f"sendrtr {_id(frame)} 0")
    return element(f"send {_id(frame)} {len(frame.data)} {frame.data.hex(' ')}")


def delivered(frame: Frame, time: float) -> bytes:
    """A frame on its way from the hub; `time` in seconds since 1970.

    The space behind the time stands there even if no data follow: python-can counts on it.
    """
    if frame.remote:
        return element(f"rtr {_id(frame)} {time:.6f} 0")
    return element(f"frame {_id(frame)} {time:.6f} {frame.data.hex().upper()}")


def read_sent(text: str) -> Frame:
    """The frame of an element that came to the hub.

    python-can cannot say `sendrtr`, it sends a remote frame as one with a length and without data.
    Of length 0 it could be a data frame, too, but on the identifiers of TPDOs and of node guarding
    a frame without data makes sense to nobody.

    Raises:
        Refused: this is no frame, or none of classic CAN.
    """
    if match := SEND_REMOTE.fullmatch(text):
        return _frame(match["id"], remote=True)
    if not (match := SEND.fullmatch(text)):
        raise Refused("no frame of classic CAN")
    data = bytes(int(byte, 16) for byte in match["data"].split())
    frame, length = _frame(match["id"], data), int(match["length"])
    if not data and (length or _makes_sense_as_remote(frame)):
        return frame._replace(remote=True, data=b"")
    if length != len(data):
        raise Refused(f"{len(data)} bytes of {length}")
    return frame


def owning(node_ids: Iterable[int]) -> str:
    """What a client says of the nodes it has, one bit for each; empty if it has none."""
    ids = sum(1 << node_id for node_id in set(node_ids) if node_id in NODE_IDS)
    return f"own {ids:032X}" if ids else ""


def read_owning(text: str) -> frozenset[int]:
    """The node ids of an element that came to the hub.

    Raises:
        Refused: there are none in it.
    """
    if not (match := OWN.fullmatch(text)):
        raise Refused("no node ids: own and 32 hexadecimal digits, a bit for each")
    ids = int(match["ids"], 16)
    return frozenset(node_id for node_id in NODE_IDS if ids >> node_id & 1)


def _makes_sense_as_remote(frame: Frame) -> bool:
    known = None if frame.extended else classify(frame.can_id)
    return known is not None and known.cob in ASKED_FOR


def read_delivered(text: str) -> Frame | None:
    """The frame of an element that came from the hub, none if it is about something else."""
    if match := REMOTE.fullmatch(text):
        return _frame(match["id"], remote=True)
    if match := FRAME.fullmatch(text):
        return _frame(match["id"], bytes.fromhex(match["data"]))
    return None


def _id(frame: Frame) -> str:
    return f"{frame.can_id:08X}" if frame.extended else f"{frame.can_id:03X}"


def _frame(digits: str, data: bytes = b"", remote: bool = False) -> Frame:
    """Identifiers of eight digits are those of 29 bits."""
    can_id, extended = int(digits, 16), len(digits) == 8
    if can_id >= (1 << 29 if extended else 1 << 11):
        raise Refused(f"there is no identifier {digits}")
    return Frame(can_id, data, remote, extended)
