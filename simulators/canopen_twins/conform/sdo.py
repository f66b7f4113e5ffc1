"""Topics about SDO: what is asked in one frame, in segments and in blocks, and what is refused."""

from canopen.objectdictionary import ODVariable

from canopen_twins.bus import sdo
from canopen_twins.bus.frame import Frame
from canopen_twins.bus.sdo import Address, Ccs, Scs, Sub
from canopen_twins.conform.tester import SILENCE, Failed, NotApplicable, Tester
from canopen_twins.conform.topic import Group
from canopen_twins.slave.dictionary import address_text
from canopen_twins.slave.object import Abort

SDO = Group(2, "SDO", "sdo")

DOWNLOADS, UPLOADS = "CiA 301, 7.2.4.3.3", "CiA 301, 7.2.4.3.5"
SEGMENTS, BLOCKS = "CiA 301, 7.2.4.3.4", "CiA 301, 7.2.4.3.9"
CODES = "CiA 301, 7.2.4.3.17"
DEVICE_TYPE: Address = (0x1000, 0)
ABSENT = 0x1004  # reserved by CiA 301
COMMANDS = (0x1003, 0x1010, 0x1011, 0x1F50, 0x1F51)  # writing these does something
TEXTS = ((0x1008, 0), (0x1009, 0), (0x100A, 0))
NO_LENGTH = (Abort.LENGTH, Abort.TOO_LONG, Abort.TOO_SHORT)


def changeable(tester: Tester, smallest: int = 1, largest: int = 4) -> ODVariable:
    """An entry of a size in bytes that a master may read and write, and that does nothing.

    Raises:
        NotApplicable: there is none.
    """
    for entry in sorted(tester.entries(), key=lambda entry: entry.index != 0x1017):
        may = entry.readable and entry.writable and entry.index not in COMMANDS
        is_number = entry.data_type in entry.STRUCT_TYPES
        if may and is_number and smallest <= tester.size(address_of(entry)) <= largest:
            return entry
    raise NotApplicable(f"no entry of {smallest} to {largest} bytes can be read and written")


def address_of(entry: ODVariable) -> Address:
    """Index and sub-index."""
    return entry.index, entry.subindex


def _opened(tester: Tester) -> Address:
    """Begin to read an entry in segments; the server has answered with the first frame."""
    for address in TEXTS:
        if tester.entry(*address) is not None:
            answer = tester.ask(sdo.message(Ccs.UPLOAD, sdo.multiplexer(address)))
            if sdo.is_abort(answer):
                code = sdo.abort_code(answer)
                raise Failed(f"{address_text(address)} cannot be read: {code:08X}h")
            if not sdo.is_expedited(answer):
                return address
    raise NotApplicable("no text has more than four bytes")


def _announced(tester: Tester) -> tuple[Address, bytes]:
    """Begin to write two bytes or more in segments, with the value that is there."""
    address = address_of(changeable(tester, 2))
    value = tester.read(address)
    named = sdo.multiplexer(address)
    answer = tester.ask(sdo.announcing(Ccs.DOWNLOAD, named, len(value)))
    if answer[:4] != bytes([Scs.DOWNLOAD << 5]) + named:
        code = f" with {sdo.abort_code(answer):08X}h" if sdo.is_abort(answer) else ""
        raise Failed(f"segments for {address_text(address)} are refused{code}")
    return address, value


def _segment(part: bytes, toggle: int = 0) -> bytes:
    """The last one of a download."""
    unused = sdo.SEGMENT_ROOM - len(part)
    return sdo.message(Ccs.DOWNLOAD_SEGMENT, part, toggle | unused << 1 | sdo.LAST)


@SDO.topic(UPLOADS)
def reads_expedited(tester: Tester) -> None:
    """The device type is read in one frame, with its size and its index."""
    answer = tester.ask(sdo.message(Ccs.UPLOAD, sdo.multiplexer(DEVICE_TYPE)))
    if answer[:4] != bytes.fromhex("43001000"):
        raise Failed(f"{Frame(tester.answers, answer)} instead of 43 00 10 00")


@SDO.topic(DOWNLOADS)
def writes_expedited(tester: Tester) -> None:
    """An entry takes the value that it has, in one frame."""
    address = address_of(changeable(tester))
    value = tester.read(address)
    tester.write(address, value)
    if (now := tester.read(address)) != value:
        raise Failed(f"{address_text(address)} is {now.hex()} after {value.hex()} was written")


@SDO.topic(CODES)
def refuses_writing_read_only(tester: Tester) -> None:
    """The device type cannot be written: 06010002h."""
    value = tester.read(DEVICE_TYPE)
    tester.expect_refusal(DEVICE_TYPE, value, Abort.READ_ONLY)


@SDO.topic(CODES)
def refuses_reading_write_only(tester: Tester) -> None:
    """An entry that is write-only cannot be read: 06010001h."""
    for entry in tester.entries():
        if not entry.readable:
            answer = tester.ask(sdo.message(Ccs.UPLOAD, sdo.multiplexer(address_of(entry))))
            tester.expect_abort(answer, f"reading {address_text(address_of(entry))}", 0x06010001)
            return
    raise NotApplicable("nothing is write-only")


@SDO.topic(CODES)
def refuses_reading_absent_subindex(tester: Tester) -> None:
    """A sub-index that is not there cannot be read: 06090011h."""
    answer = tester.ask(sdo.message(Ccs.UPLOAD, sdo.multiplexer((0x1000, 1))))
    tester.expect_abort(answer, "reading 0x1000:01", Abort.NO_SUBINDEX)
    answer = tester.ask(sdo.message(Ccs.UPLOAD, sdo.multiplexer((0x1018, 0x7F))))
    tester.expect_abort(answer, "reading 0x1018:7F", Abort.NO_SUBINDEX)


@SDO.topic(CODES)
def refuses_reading_absent_object(tester: Tester) -> None:
    """An object that is not there cannot be read: 06020000h."""
    answer = tester.ask(sdo.message(Ccs.UPLOAD, sdo.multiplexer((ABSENT, 0))))
    tester.expect_abort(answer, f"reading 0x{ABSENT:04X}", Abort.NO_OBJECT)


@SDO.topic(CODES)
def refuses_unknown_command(tester: Tester) -> None:
    """A command specifier that does not exist is refused: 05040001h."""
    answer = tester.ask(sdo.message(7, sdo.multiplexer(DEVICE_TYPE)))
    tester.expect_abort(answer, "E0h", Abort.COMMAND)


@SDO.topic(CODES)
def refuses_too_long(tester: Tester) -> None:
    """More bytes than an entry has are refused: 06070010h or 06070012h."""
    address = address_of(changeable(tester, 1, 3))
    value = tester.read(address).ljust(4, b"\0")
    tester.expect_refusal(address, value, Abort.LENGTH, Abort.TOO_LONG)


@SDO.topic(CODES)
def refuses_too_short(tester: Tester) -> None:
    """Fewer bytes than an entry has are refused: 06070010h or 06070013h."""
    address = address_of(changeable(tester, 2))
    value = tester.read(address)[:1]
    tester.expect_refusal(address, value, Abort.LENGTH, Abort.TOO_SHORT)


@SDO.topic(CODES)
def refuses_too_high(tester: Tester) -> None:
    """A value above the high limit is refused: 06090030h or 06090031h."""
    for entry in tester.entries():
        if (value := above(entry)) is not None:
            codes = (Abort.INVALID_VALUE, Abort.TOO_HIGH)
            tester.expect_refusal(address_of(entry), value, *codes)
            return
    raise NotApplicable("no entry that can be written has a high limit")


@SDO.topic(CODES)
def refuses_too_low(tester: Tester) -> None:
    """A value below the low limit is refused: 06090030h or 06090032h."""
    for entry in tester.entries():
        if (value := below(entry)) is not None:
            codes = (Abort.INVALID_VALUE, Abort.TOO_LOW)
            tester.expect_refusal(address_of(entry), value, *codes)
            return
    raise NotApplicable("no entry that can be written has a low limit")


def above(entry: ODVariable) -> bytes | None:
    """A value just above the limit of an entry, none if it has none that its type could pass."""
    return _beyond(entry, entry.max, 1)


def below(entry: ODVariable) -> bytes | None:
    """The same below."""
    return _beyond(entry, entry.min, -1)


def _beyond(entry: ODVariable, limit: int | None, step: int) -> bytes | None:
    whole = entry.writable and entry.data_type in (*range(2, 8), 0x15, 0x1B)
    if limit is None or not whole or entry.index in COMMANDS:
        return None
    size = entry.STRUCT_TYPES[entry.data_type or 0].size
    signed = entry.data_type in (2, 3, 4, 0x15)
    low, high = (-(1 << 8 * size - 1), 1 << 8 * size - 1) if signed else (0, 1 << 8 * size)
    value = limit + step
    return value.to_bytes(size, "little", signed=signed) if low <= value < high else None


@SDO.topic("CiA 301, 7.5.2.33")
def has_default_server(tester: Tester) -> None:
    """The identifiers in 0x1200 are those of the default SDO server."""
    tester.need(0x1200, 1)
    for subindex, can_id in ((1, tester.requests), (2, tester.answers)):
        told = tester.number(0x1200, subindex)
        if told != can_id:
            raise Failed(f"0x1200:{subindex:02X} is {told:X}h instead of {can_id:X}h")


@SDO.topic(SEGMENTS)
def reads_segmented(tester: Tester) -> None:
    """A text is read in segments: as many bytes as announced, the toggle bit alternates."""
    address = _opened(tester)
    announced = sdo.size(tester.frames[-1].data)
    value = tester.read(address)
    if announced is not None and announced != len(value):
        raise Failed(f"{len(value)} bytes of {address_text(address)}, {announced} were announced")


@SDO.topic(SEGMENTS)
def aborts_upload_without_toggle(tester: Tester) -> None:
    """A segment that is asked for with the wrong toggle bit ends the transfer: 05030000h."""
    _opened(tester)
    answer = tester.ask(sdo.message(Ccs.UPLOAD_SEGMENT, flags=sdo.TOGGLE))
    tester.expect_abort(answer, "70h", Abort.TOGGLE)


@SDO.topic(SEGMENTS)
def writes_segmented(tester: Tester) -> None:
    """A value of at most four bytes is written in a segment."""
    address, value = _announced(tester)
    answer = tester.ask(_segment(value))
    if answer[0] != Scs.DOWNLOAD_SEGMENT << 5 or tester.read(address) != value:
        raise Failed(f"{Frame(tester.answers, answer)} instead of 20h")


@SDO.topic(SEGMENTS)
def aborts_download_without_toggle(tester: Tester) -> None:
    """A segment with the wrong toggle bit ends a download: 05030000h."""
    _, value = _announced(tester)
    answer = tester.ask(_segment(value, sdo.TOGGLE))
    tester.expect_abort(answer, "a segment with toggle bit 1", Abort.TOGGLE)


@SDO.topic(CODES)
def refuses_more_than_announced(tester: Tester) -> None:
    """A segment with more bytes than announced is refused: 06070010h or 06070012h."""
    _, value = _announced(tester)
    answer = tester.ask(_segment(value + b"\0"))
    tester.expect_abort(answer, "a byte too many", Abort.LENGTH, Abort.TOO_LONG)


@SDO.topic(CODES)
def refuses_less_than_announced(tester: Tester) -> None:
    """A last segment with fewer bytes than announced is refused: 06070010h or 06070013h."""
    _, value = _announced(tester)
    answer = tester.ask(_segment(value[:-1]))
    tester.expect_abort(answer, "a byte too few", Abort.LENGTH, Abort.TOO_SHORT)


@SDO.topic(CODES)
def refuses_segments_of_no_transfer(tester: Tester) -> None:
    """Segments of no transfer are refused: 05040001h."""
    for command in (Ccs.UPLOAD_SEGMENT, Ccs.DOWNLOAD_SEGMENT):
        answer = tester.ask(sdo.message(command))
        tester.expect_abort(answer, f"{command << 5:02X}h", Abort.COMMAND)


@SDO.topic("CiA 301, 7.2.4.3.17")
def is_aborted_by_client(tester: Tester) -> None:
    """An abort of the client ends the transfer and is not answered."""
    address = _opened(tester)
    tester.send(tester.requests, sdo.abort(sdo.multiplexer(address), Abort.TIME_OUT))
    tester.expect_silence(tester.answers, "answers an abort")
    answer = tester.ask(sdo.message(Ccs.UPLOAD_SEGMENT))
    tester.expect_abort(answer, "60h after an abort", Abort.COMMAND)


@SDO.topic(UPLOADS)
def begins_anew(tester: Tester) -> None:
    """Another request takes the place of an open transfer."""
    _opened(tester)
    tester.read(DEVICE_TYPE)
    answer = tester.ask(sdo.message(Ccs.UPLOAD_SEGMENT))
    tester.expect_abort(answer, "60h after another request", Abort.COMMAND)


@SDO.topic(CODES)
def refuses_writing_absent_subindex(tester: Tester) -> None:
    """A sub-index that is not there cannot be written: 06090011h."""
    tester.expect_refusal((0x1000, 1), 0, Abort.NO_SUBINDEX)


@SDO.topic(CODES)
def refuses_writing_absent_object(tester: Tester) -> None:
    """An object that is not there cannot be written: 06020000h."""
    tester.expect_refusal((ABSENT, 0), 0, Abort.NO_OBJECT)


@SDO.topic(DOWNLOADS)
def writes_without_size(tester: Tester) -> None:
    """A value that leaves its size open is taken as it is, or refused for its length."""
    address = address_of(changeable(tester))
    value = tester.read(address)
    request = sdo.expedited(Ccs.DOWNLOAD, sdo.multiplexer(address), value, sized=False)
    answer = tester.ask(request)
    if sdo.is_abort(answer):
        tester.expect_abort(answer, "22h", *NO_LENGTH)
    if (now := tester.read(address)) != value:
        raise Failed(f"{address_text(address)} is {now.hex()} after {value.hex()} was written")


@SDO.topic("CiA 301, 7.2.4.3")
def ignores_short_requests(tester: Tester) -> None:
    """A request that is shorter than eight bytes is not carried out."""
    tester.send(tester.requests, sdo.message(Ccs.UPLOAD, sdo.multiplexer(DEVICE_TYPE))[:4])
    for frame in tester.listen(SILENCE):
        if frame.can_id == tester.answers and not sdo.is_abort(frame.data):
            raise Failed(f"{frame} answers four bytes")


def _block_upload(tester: Tester, address: Address, blksize: int, crc: bool) -> bytes:
    """The answer to the begin of a block upload; a switch to another protocol is ruled out.

    Raises:
        NotApplicable: there is no block transfer.
    """
    flags = Sub.INITIATE | (sdo.BLOCK_CRC if crc else 0)
    content = sdo.multiplexer(address) + bytes([blksize, 0])
    answer = tester.ask(sdo.message(Ccs.BLOCK_UPLOAD, content, flags))
    return _offered(tester, answer, Scs.BLOCK_UPLOAD)


def _offered(tester: Tester, answer: bytes, specifier: int) -> bytes:
    if sdo.is_abort(answer) and sdo.abort_code(answer) == Abort.COMMAND:
        raise NotApplicable("block transfer is optional, and is refused with 05040001h")
    if not sdo.is_abort(answer) and sdo.specifier(answer) != specifier:
        raise Failed(f"{Frame(tester.answers, answer)} is no answer to a block transfer")
    return answer


def _read_in_blocks(tester: Tester, crc: bool) -> None:
    """Read a text, or the device type, in blocks of two segments."""
    address = next((each for each in TEXTS if tester.entry(*each) is not None), DEVICE_TYPE)
    expected = tester.read(address)
    begin = _block_upload(tester, address, 2, crc=crc)
    if sdo.is_abort(begin):
        raise Failed(f"{address_text(address)} is refused with {sdo.abort_code(begin):08X}h")
    tester.send(tester.requests, sdo.message(Ccs.BLOCK_UPLOAD, flags=Sub.START))
    received, number, last = b"", 0, False
    while not last:
        number += 1
        segment = tester.hear(tester.answers, length=sdo.LENGTH)
        if sdo.block_number(segment) != number:
            raise Failed(f"{segment.hex()} is not segment {number} of its block")
        received += segment[1:]
        if len(received) > len(expected) + sdo.SEGMENT_ROOM:
            raise Failed(f"more than the {len(expected)} bytes of {address_text(address)}")
        last = bool(segment[0] & sdo.LAST_OF_BLOCKS)
        if last or number == 2:
            confirm = bytes([number, 2])
            tester.send(tester.requests, sdo.message(Ccs.BLOCK_UPLOAD, confirm, Sub.CONFIRM))
            number = 0
    end = tester.hear(tester.answers, length=sdo.LENGTH)
    value = sdo.block_value(end, received)
    tester.send(tester.requests, sdo.message(Ccs.BLOCK_UPLOAD, flags=Sub.END))
    if value != expected:
        raise Failed(f"{value.hex()} instead of {expected.hex()}")
    if crc and begin[0] & sdo.BLOCK_CRC and sdo.block_checksum(end) != sdo.crc(value):
        raise Failed(f"checksum {sdo.block_checksum(end):04X}h of {value.hex()}")


@SDO.topic(BLOCKS)
def reads_in_blocks(tester: Tester) -> None:
    """A value is read in blocks."""
    _read_in_blocks(tester, crc=False)


@SDO.topic("CiA 301, 7.2.4.3.16")
def reads_in_blocks_with_checksum(tester: Tester) -> None:
    """A value is read in blocks, and its checksum is right."""
    _read_in_blocks(tester, crc=True)


@SDO.topic(CODES)
def refuses_block_sizes(tester: Tester) -> None:
    """Blocks of 0 and of 128 segments are refused: 05040002h."""
    for blksize in (0, 128):
        answer = _block_upload(tester, DEVICE_TYPE, blksize, crc=False)
        tester.expect_abort(answer, f"a block of {blksize} segments", Abort.BLOCK_SIZE)


def _write_in_blocks(tester: Tester, checksum: int) -> bytes:
    """Write an entry as it is with a checksum that is changed; the answer to the end."""
    address = address_of(changeable(tester))
    value = tester.read(address)
    flags = Sub.INITIATE | sdo.BLOCK_CRC | sdo.BLOCK_SIZED
    content = sdo.multiplexer(address) + len(value).to_bytes(4, "little")
    answer = tester.ask(sdo.message(Ccs.BLOCK_DOWNLOAD, content, flags))
    begin = _offered(tester, answer, Scs.BLOCK_DOWNLOAD)
    if sdo.is_abort(begin):
        raise Failed(f"{address_text(address)} is refused with {sdo.abort_code(begin):08X}h")
    if checksum and not begin[0] & sdo.BLOCK_CRC:
        raise NotApplicable("checksums are optional, and there are none")
    confirmed = tester.ask(sdo.block_segment(value, 0, 1))
    if confirmed[:2] != bytes([Scs.BLOCK_DOWNLOAD << 5 | Sub.CONFIRM, 1]):
        raise Failed(f"{confirmed.hex()} does not confirm the segment")
    end = sdo.block_end(Ccs.BLOCK_DOWNLOAD, len(value), sdo.crc(value) ^ checksum)
    return tester.ask(end)


@SDO.topic(BLOCKS)
def writes_in_blocks(tester: Tester) -> None:
    """A value is written in a block."""
    answer = _write_in_blocks(tester, 0)
    if answer[0] != Scs.BLOCK_DOWNLOAD << 5 | Sub.END:
        raise Failed(f"{answer.hex()} instead of A1h")


@SDO.topic(CODES)
def refuses_wrong_checksum(tester: Tester) -> None:
    """A block with a wrong checksum is refused: 05040004h."""
    tester.expect_abort(_write_in_blocks(tester, 1), "a wrong checksum", Abort.CRC)


GROUPS = (SDO,)
