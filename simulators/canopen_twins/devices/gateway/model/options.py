"""What no manual prints and a user may want otherwise: times, and readings of the text."""

from dataclasses import dataclass

from canopen_twins.devices.gateway.model.canopen_side import FirstTpdo


@dataclass(frozen=True)
class Options:
    """Times in seconds, multiples of 125 us."""

    governor_cycle: float = 0.015625
    """Main cycle of the governor; the manual's formulas hold for this one (7.1.3, A-43)."""
    gateway_cycle: float = 0.016
    """Main cycle of the gateway (7.2.3)."""
    boot_time: float = 0.2
    """Bootloader tests and start of the programme, in both units (9.3)."""
    lowest_voltage: float = 7.5
    """Supply below which 3085 is reported, V (9.4, A-42)."""
    first_tpdo: FirstTpdo = FirstTpdo.ALWAYS
    """Whether TPDO1 to 3 are sent on entering Operational (A-15)."""
    always_armed: bool = False
    """Whether the partner is missed in Operational even before its first heartbeat (A-19)."""
