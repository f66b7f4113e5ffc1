"""How long a frame takes on the bus: bits with stuffing (ISO 11898-1)."""

from simulators.frame import Frame

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
