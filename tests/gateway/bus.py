"""What a master of the gateway at node 1 sends, in the notation of cansend."""

START, STOP, ENTER_PREOP = "000#0101", "000#0201", "000#8001"
RESET_NODE, RESET_COMMUNICATION = "000#8101", "000#8201"
BOOT_UP = "701#00"


def read(bench, index, subindex=0):
    """The value of an object, or minus the abort code."""
    (answer,) = bench.send(f"601#40{index & 0xFF:02X}{index >> 8:02X}{subindex:02X}00000000")
    data = bytes.fromhex(answer.removeprefix("581#"))
    value = int.from_bytes(data[4:], "little")
    return -value if data[0] == 0x80 else value


def heard(frames, identifier):
    """The data of the frames with this identifier."""
    return [frame[4:] for frame in frames if frame.startswith(f"{identifier}#")]


def word(bench):
    """2005h, as a master reads it."""
    return read(bench, 0x2005)
