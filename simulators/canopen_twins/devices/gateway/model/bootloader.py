"""Bootloader of a control unit: what it tests at every start, and shows if it stays (9.3)."""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum

from canopen_twins.devices.gateway.model import errors

# 9.3.2: all that can be read while the bootloader does not hand on
FROM_BOOTLOADER = (
    *(3075, 3076, 3078, 3079, 3087, 3089, 3094, 3095, 3096, 3097, 3098),
    *(3800, 3801, 3802, 3803, 3840, 3841, 3842, 3850, 3870),
)
TEST_STATUS_ERRORS: Mapping[int, int] = {  # 9.3.3, code of 3800 -> error
    1: errors.RAM_TEST,
    **dict.fromkeys(range(2, 10), errors.MAIN_CHECKSUM),
    10: errors.PARAM_STORE,  # read ErrEEPROM in the bootloader
}
# 9.3.3: 3801 to 3803 by code of 3800. What is not printed (addresses, patterns, sums) is A-61.
TEST_VALUES: Mapping[int, tuple[int, int, int]] = {
    1: (0xE1A4, 0x5555, 0x5545),  # error address, test value, content of the address
    2: (0, 0, 0),  # main check sum
    3: (0x6C2B, 0, 0),  # main check sum, length
    4: (0x6C2B, 0xFFFF, 0xFFFF),  # main check sum, length
    5: (0xFFFF, 0xFFFF, 0),  # NMI address
    6: (0x0008, 0x0001, 0xFFFF),  # NMI address, its content
    7: (0xFFFF, 0xFFFF, 0),  # programme start address
    8: (0x0400, 0x0001, 0xFFFF),  # programme start address, its content
    9: (0x6C2A, 0x6C2B, 0),  # calculated and stored check sum
    10: (0, 0, 0),
}
WATCHDOG_EXCEPTION = 3


class EndlessLoop(Enum):
    """Tests after which the bootloader stays in an endless loop: no communication at all."""

    WATCHDOG = "watchdog test"
    CHECKSUM = "bootloader programme test"
    RAM = "bootloader RAM test"


@dataclass(frozen=True)
class Finding:
    """Why the bootloader stays, for whoever reads its parameters."""

    error: int | None = None
    """3078, 3087, 3089 or 3076."""
    status: int = 0
    """3800 TestStatus."""
    values: tuple[int, int, int] = (0, 0, 0)
    """3801 to 3803, whose meaning depends on the status."""
    exception: tuple[int, int, int, int] = (0, 0, 0, 0)
    """3095 to 3098: number, address low and high, flags."""

    @classmethod
    def of_test(cls, status: int, values: tuple[int, int, int] | None = None) -> "Finding":
        """A test failed with this TestStatus and its three values, or usual ones (9.3.3, A-61).

        Raises:
            ValueError: no such status.
        """
        if status not in TEST_STATUS_ERRORS:
            raise ValueError(f"3800 TestStatus: {status} is not in 1..10")
        shown = TEST_VALUES[status] if values is None else values
        return cls(TEST_STATUS_ERRORS[status], status, shown)

    @classmethod
    def of_watchdog(cls, address: int = 0, flags: int = 0) -> "Finding":
        """The watchdog ended the programme at this address (9.3.1)."""
        exception = (WATCHDOG_EXCEPTION, address & 0xFFFF, address >> 16 & 0xFFFF, flags)
        return cls(errors.WATCHDOG, exception=exception)


NOTHING = Finding()


class Eeprom(Enum):
    """Bits of 3099 EEPROMErrorCode, which have an effect at the next start (9.4)."""

    BOOTLOADER_PAGE = 0
    SERIAL_NUMBER = 3
    ERROR_MEMORY = 4
    PARAMETERS = 5
    EXCEPTION = 6


class Bootloader:
    """Runs first after every reset; what it will find is set by the faults of the unit."""

    def __init__(self) -> None:
        self.finding: Finding | EndlessLoop | None = None
        self.eeprom_code = 0

    def damaged(self, part: Eeprom) -> bool:
        """Whether this part of the EEPROM is faulty."""
        return bool(self.eeprom_code >> part.value & 1)

    @property
    def stays(self) -> bool:
        """Whether the programme is not handed on to."""
        return self.finding is not None or self.damaged(Eeprom.BOOTLOADER_PAGE)

    @property
    def silent(self) -> bool:
        """Whether not even DcDesk gets an answer."""
        return isinstance(self.finding, EndlessLoop)

    def shows(self, number: int) -> int:
        """One of the parameters 3075..3098 and 3800..3803, as the bootloader reports it."""
        finding = self.finding if isinstance(self.finding, Finding) else NOTHING
        table = {
            **dict(zip(range(3095, 3099), finding.exception, strict=True)),
            3800: finding.status,
            **dict(zip(range(3801, 3804), finding.values, strict=True)),
        }
        return table.get(number, int(number == finding.error))
