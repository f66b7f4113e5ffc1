"""Registers behind 0x2100 (7.3.16): an address, then a value; their meaning is the maker's."""

import re
from collections.abc import Mapping

from simulators.devices.topcon.panel import Panel
from simulators.objects import Abort, Address, Object, Rejected

WIDE_FROM = [4, 20]  # firmware from which addresses have 24 bits


class Registers:
    """The card's window on a sparse store of 16-bit registers; unwritten ones read 0 (A-56)."""

    def __init__(self, firmware: str, values: dict[int, int], panel: Panel) -> None:
        version = [int(number) for number in re.findall(r"\d+", firmware)]
        self.address_bits = 24 if version >= WIDE_FROM else 16
        self.address = 0
        self._values = values
        self._panel = panel

    @property
    def objects(self) -> Mapping[Address, Object]:
        """Address and value."""
        return {
            (0x2100, 1): Object(read=lambda: self.address, write=self._select),
            (0x2100, 2): Object(read=lambda: self._values.get(self.address, 0), write=self._write),
        }

    def _select(self, address: int) -> None:
        if address >> self.address_bits:
            reason = f"this firmware has addresses of {self.address_bits} bits"
            raise Rejected(reason, Abort.TOO_HIGH)
        self.address = address

    def _write(self, value: int) -> None:
        if self._panel.yields(f"register {self.address:#x}"):
            self._values[self.address] = value
