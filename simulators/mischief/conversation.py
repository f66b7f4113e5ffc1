"""Which object an SDO conversation is about, and how far it has come, as seen from the bus."""

from simulators.objects import Address

READ, WRITE = "read", "write"
ABORT = 0x80
INITIATES = frozenset({*range(0x20, 0x60), *range(0xA0, 0xC0, 4), *range(0xC0, 0xE0, 2)})
READS = frozenset({*range(0x40, 0x60), *range(0xA0, 0xC0)})
BLOCK_DOWNLOADS = range(0xC0, 0xE0)
END_OF_BLOCK_DOWNLOAD = 0xA1


class Conversation:
    """`segment` is 0 for the initiate and counts the requests of the transfer after it."""

    def __init__(self) -> None:
        self.address: Address | None = None
        self.access = ""
        self.segment = 0
        self._raw = False  # segments of a block download: their first byte is no command

    def ask(self, data: bytes) -> None:
        """The client has sent a request."""
        if data[0] == ABORT:
            self.address, self._raw = None, False
        elif data[0] in INITIATES and not self._raw:
            self.address = (data[1] | data[2] << 8, data[3])
            self.access = READ if data[0] in READS else WRITE
            self.segment = 0
            self._raw = data[0] in BLOCK_DOWNLOADS
        else:
            self.segment += 1

    def answer(self, data: bytes) -> None:
        """The server has answered."""
        if data[0] in (ABORT, END_OF_BLOCK_DOWNLOAD):
            self._raw = False
