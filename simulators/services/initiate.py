"""SDO initiates: each is answered at once or begins a transfer (CiA 301, 7.2.4.3)."""

from collections.abc import Callable, Mapping

from simulators.entry import Entry
from simulators.objects import Abort, Rejected
from simulators.profile import Profile
from simulators.services.block import BlockDownload, BlockUpload
from simulators.services.transfer import Download, Target, Transfer, Upload
from simulators.slave import Slave

EXPEDITED_ROOM = 4
EXPEDITED_UPLOAD = {size: bytes([0x43 | 4 - size << 2]) for size in range(1, 5)}

DOWNLOADS, UPLOADS = range(0x20, 0x40), range(0x40, 0x60)
BLOCK_UPLOADS, BLOCK_DOWNLOADS = range(0xA0, 0xC0, 4), range(0xC0, 0xE0, 2)
LITERAL_COMMANDS = frozenset({*range(0x20, 0x30), 0x40})
EXPEDITED = 2  # bit of a download: the value has come along

Initiate = Callable[[Slave, Entry, bytes], bytes | Transfer]


def initiates(profile: Profile) -> Mapping[int, Initiate]:
    """What the server offers, by command byte."""
    table: dict[int, Initiate] = dict.fromkeys(DOWNLOADS, download)
    if not profile.segmented and not profile.literal_commands:  # literally, 20h and 21h are known
        table = {command: table[command] for command in table if command & EXPEDITED}
    table |= dict.fromkeys(UPLOADS, upload)
    if profile.block:
        table |= dict.fromkeys(BLOCK_DOWNLOADS, block_download)
        table |= dict.fromkeys(BLOCK_UPLOADS, block_upload)
    if profile.literal_commands:
        return {command: table[command] for command in table if command in LITERAL_COMMANDS}
    return table


def upload(slave: Slave, entry: Entry, data: bytes) -> bytes | Transfer:
    """Read, in one frame if the value fits."""
    return _upload(slave, data, _read(entry))


def block_upload(slave: Slave, entry: Entry, data: bytes) -> bytes | Transfer:
    """Read in blocks, unless the value is so short that the client wants it the other way."""
    value, blksize, switch_up_to = _read(entry), data[4], data[5]
    if switch_up_to and len(value) <= switch_up_to:
        return _upload(slave, data, value)
    return BlockUpload(value, blksize, crc=bool(data[0] & 4))


def download(slave: Slave, entry: Entry, data: bytes) -> bytes | Transfer:
    """Write, at once if the value has come along."""
    if not data[0] & EXPEDITED:
        size = int.from_bytes(data[4:], "little") if data[0] & 1 else None
        _check_download(slave, entry, size)
        return Download(Target(slave, entry, size))
    size = EXPEDITED_ROOM - (data[0] >> 2 & 3) if data[0] & 1 else None
    _check_download(slave, entry, size)
    room = entry.size if size is None else size  # without a size as many as the object has
    slave.write(entry, data[4 : 4 + (EXPEDITED_ROOM if room is None else room)])
    return b"\x60" + data[1:4] + bytes(4)


def block_download(slave: Slave, entry: Entry, data: bytes) -> bytes | Transfer:
    """Write in blocks."""
    size = int.from_bytes(data[4:], "little") if data[0] & 2 else None
    _check_download(slave, entry, size)
    return BlockDownload(Target(slave, entry, size), crc=bool(data[0] & 4))


def _read(entry: Entry) -> bytes:
    if not entry.readable:
        raise Rejected("write only", Abort.WRITE_ONLY)
    return entry.read()


def _upload(slave: Slave, data: bytes, value: bytes) -> bytes | Transfer:
    if head := EXPEDITED_UPLOAD.get(len(value)):
        return head + data[1:4] + value.ljust(EXPEDITED_ROOM, b"\0")
    if not slave.profile.segmented:
        raise Rejected(f"{len(value)} bytes fit no expedited transfer", Abort.NOT_TRANSFERABLE)
    return Upload(value)


def _check_download(slave: Slave, entry: Entry, size: int | None) -> None:
    checks = [_check_access, _check_length]
    if slave.profile.length_before_access:
        checks.reverse()
    for check in checks:
        check(slave, entry, size)


def _check_access(slave: Slave, entry: Entry, size: int | None) -> None:
    if not entry.writable:
        raise Rejected("read only", Abort.READ_ONLY)


def _check_length(slave: Slave, entry: Entry, size: int | None) -> None:
    if size is not None:
        slave.check_length(entry, size)
