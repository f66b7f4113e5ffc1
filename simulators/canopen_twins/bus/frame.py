"""One CAN frame, and its notation: that of `cansend`."""

import re
from typing import NamedTuple

from canopen_twins.errors import UserError

LONGEST = 8  # data bytes of a classic CAN frame
STANDARD_IDS = range(0x800)
ANY_DIGIT, ANY_REST = "X", "*"
NOTATION = re.compile(r"(?P<id>[0-9A-Fa-f]{3}|[0-9A-Fa-f]{8})#(?P<rest>R[0-8]?|[0-9A-Fa-f.]*)")


class Frame(NamedTuple):
    """One CAN frame."""

    can_id: int
    data: bytes = b""
    remote: bool = False
    extended: bool = False

    @classmethod
    def parse(cls, text: str) -> "Frame":
        """Read the notation of `cansend`: 605#40.20.20.00, 185#R; eight digits are a 29-bit id.

        Raises:
            UserError: the text is no frame.
        """
        if not (match := NOTATION.fullmatch(text.strip())):
            raise UserError(f"{text!r} is no frame: write ID#DATA or ID#R, such as 605#4000100000")
        can_id, extended = int(match["id"], 16), len(match["id"]) == 8
        if can_id >= (1 << 29 if extended else 1 << 11):
            raise UserError(f"{text!r}: identifiers end at {'1FFFFFFF' if extended else '7FF'}")
        if match["rest"].startswith("R"):
            return cls(can_id, remote=True, extended=extended)
        return cls(can_id, _payload(text, match["rest"].replace(".", "")), extended=extended)

    def __str__(self) -> str:
        can_id = f"{self.can_id:08X}" if self.extended else f"{self.can_id:03X}"
        return f"{can_id}#{'R' if self.remote else self.data.hex().upper()}"


def _payload(text: str, digits: str) -> bytes:
    if len(digits) % 2 or len(digits) > 2 * LONGEST:
        raise UserError(f"{text!r}: data are at most {LONGEST} bytes of two hex digits each")
    return bytes.fromhex(digits)


def pattern(text: str) -> re.Pattern[str]:
    """Matches `str(frame)`: the notation of `cansend`, x for any digit, * at the end for any rest.

    Raises:
        UserError: the text is no frame with an x for some of its digits.
    """
    plain = text.strip().replace(".", "").upper()
    zeros = plain.removesuffix(ANY_REST).replace(ANY_DIGIT, "0")
    try:
        Frame.parse(zeros)
    except UserError as refusal:  # tell it of what was written
        raise UserError(str(refusal).replace(repr(zeros), repr(text))) from None
    return re.compile(plain.replace(ANY_DIGIT, "[0-9A-F]").replace(ANY_REST, ".*"))


CRC_POLYNOMIAL = 0x4599
CRC_BITS = 15
TAIL = 13  # CRC delimiter, acknowledge and its delimiter, end of frame, intermission
RUN = 5  # equal bits, after which one of the other kind is stuffed


def length(frame: Frame) -> int:
    """Bits of a frame, the intermission after it included."""
    plain = _plain(frame)
    bits = plain + f"{_crc(plain):0{CRC_BITS}b}"
    return len(bits) + _stuffed(bits) + TAIL


def _plain(frame: Frame) -> str:
    remote = "1" if frame.remote else "0"
    if frame.extended:
        can_id = f"{frame.can_id:029b}"
        head = f"0{can_id[:11]}11{can_id[11:]}{remote}00"
    else:
        head = f"0{frame.can_id:011b}{remote}00"
    return head + f"{len(frame.data):04b}" + "".join(f"{byte:08b}" for byte in frame.data)


def _crc(bits: str) -> int:
    crc = 0
    for bit in bits:
        feed = int(bit) ^ crc >> CRC_BITS - 1
        crc = crc << 1 & (1 << CRC_BITS) - 1
        if feed:
            crc ^= CRC_POLYNOMIAL
    return crc


def _stuffed(bits: str) -> int:
    """A stuffed bit counts as the first of the next run."""
    stuffed, run, last = 0, 0, ""
    for bit in bits:
        run = run + 1 if bit == last else 1
        last = bit
        if run == RUN:
            stuffed += 1
            run, last = 1, "1" if bit == "0" else "0"
    return stuffed
