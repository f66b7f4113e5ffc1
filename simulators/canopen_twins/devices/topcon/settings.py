"""Settings of the TopCon twin; an A-number marks an assumption (docs/devices/topcon.md)."""

from dataclasses import dataclass
from typing import Any, Literal

from canopen_twins.device import NodeSettings, setting

SIGNED16 = 0x7FFF


def _parts(default: int, text: str, assumed: str, high: int = SIGNED16) -> Any:
    return setting(default, text, unit="parts", assumed=assumed, low=0, high=high)


@dataclass(frozen=True)
class Settings(NodeSettings):
    """What can be chosen of a TopCon and of what is connected to it."""

    # the card
    ah: int | None = setting(
        None, "switch AH, with al instead of node_id (4.2)", live=True, low=0, high=15
    )
    al: int | None = setting(
        None, "switch AL, with ah instead of node_id (4.2)", live=True, low=0, high=15
    )
    br: int = setting(6, "switch BR, the bit rate (4.3)", live=True, low=0, high=15)
    hb_first: Literal["period", "now"] = setting(
        "period", "when the first heartbeat follows a write to 0x1017", assumed="A-23"
    )
    empty_1003: Literal["zero", "abort"] = setting(
        "zero", "what an unused entry of 0x1003 answers", assumed="A-14"
    )
    strict_cobid: bool = setting(
        False,
        "a new COB-ID wants bit 31 set by a write of its own before, an RPDO bit 30 set always",
        assumed="A-26, A-28",
    )
    quiet_time: float = setting(
        1.0, "without a frame for this node until RS-232 works", unit="s", assumed="A-07", low=0
    )

    # the unit
    unit: str = setting("TCP-32-400", "unit type, a name of the unit file", assumed="A-77")
    unit_file: str = setting("", "YAML file with further unit types", file=r"^types:")
    units: int = setting(1, "units of a system of which this is the master", assumed="A-74", low=1)
    connection: Literal["parallel", "series"] = setting("parallel", "of the units of a system")
    hardware_version: str = setting("V4.x", "0x1009", assumed="A-18")
    firmware: str = setting(
        "V4.11.45", "0x100A, and the width of register addresses", assumed="A-19, A-56"
    )
    serial: int = setting(1, "0x1018:4", assumed="A-24", low=0, high=0xFFFFFFFF)
    ready_time: float = setting(
        0.0, "from power-on until RUN works", unit="s", assumed="A-78", low=0
    )
    cooldown: float = setting(
        10.0,
        "below its limit until an overtemperature can be reset",
        unit="K",
        assumed="A-89",
        low=0,
    )

    # what is around it
    load: str = setting(
        "open",
        "open, resistor OHM, battery VOLT OHM [AH] [soc=0..1] [swing=0..1] [diode],"
        " supercapacitor FARAD OHM [VOLT], sink AMPERE, power WATT [VOLT], short,"
        " inductor OHM HENRY",
        live=True,
    )
    ambient: float = setting(
        25.0, "temperature of the air", unit="degC", assumed="A-84", live=True, low=-273
    )
    panel: Literal["remote", "local"] = setting(
        "remote", "where the HMI or RCU is turned to; remote after power-on (6)", live=True
    )

    # set values nobody has set or stored yet
    power_on_voltage: int = _parts(0, "0x2010 at power-on", "A-42")
    power_on_current: int = _parts(0, "0x2011 at power-on", "A-42")
    power_on_power: int = _parts(4000, "0x2012 at power-on", "A-42")
    power_on_resistance: int = _parts(0, "0x2013 at power-on", "A-42")
    power_on_overvoltage: int = _parts(4400, "0x2030 at power-on", "A-42", high=4400)
    power_on_overcurrent: int = _parts(4400, "0x2031 at power-on", "A-42", high=4400)
    set_value_range: int = _parts(4000, "highest set value taken", "A-40")

    # what the manual leaves open
    local_write: Literal["ignore", "abort"] = setting(
        "ignore",
        "a setting from the bus while the panel is local: confirmed and dropped, or refused",
        assumed="A-08",
    )
    on_remote: Literal["keep", "stop"] = setting(
        "keep", "the output when Operational ends local control", assumed="A-09"
    )
    on_leave_operational: Literal["keep", "stop"] = setting(
        "keep", "the output when the node leaves Operational", assumed="A-58"
    )
    run_while_error: Literal["ignore", "abort", "emcy"] = setting(
        "ignore", "RUN while an error is active", assumed="A-47"
    )
    ovp_when_off: bool = setting(
        True, "whether overvoltage is watched with the output off", assumed="A-57"
    )
