"""Settings of the gateway twin; an A-number marks an assumption (docs/devices/gateway.md)."""

from dataclasses import dataclass
from typing import Literal

from canopen_twins.device.settings import TimingSettings, setting


@dataclass(frozen=True)
class Settings(TimingSettings):
    """What can be chosen of a governor with its gateway, and of the engine it governs."""

    # parameters
    node_id: int | None = setting(
        None, "427 of the gateway as delivered, before that of the configuration", low=1, high=127
    )
    config: str = setting(
        "",
        "YAML file with parameters of both units, or the name of one that is shipped; what DcDesk"
        " has saved wins",
        file=r"^(gateway|governor):",
    )

    # what the manual leaves to other manuals
    scaling: str = setting(
        "",
        "CSV file with internal value ranges instead of ours",
        assumed="A-18",
        file=r"\Anumber,full_scale,",
    )
    error_bits: str = setting(
        "",
        "YAML file with the meaning of 2000h instead of ours",
        assumed="A-13, A-33",
        file=r"^error bits:",
    )
    governor_cycle: float = setting(
        0.015625, "main cycle of the governor", unit="s", assumed="A-43", low=0.000125
    )
    boot_time: float = setting(
        0.2, "from reset to the start of the programme, in both units", unit="s", low=0.000125
    )
    lowest_voltage: float = setting(
        7.5, "supply below which 3085 is reported", unit="V", assumed="A-42"
    )

    # what the manual leaves open
    emcy: Literal["none", "assumed"] = setting(
        "none", "emergencies, which the device does not have: an extension", assumed="A-01"
    )
    error_register: Literal["bits", "zero"] = setting("bits", "what 0x1001 shows", assumed="A-07")
    first_tpdo: Literal["always", "nonzero", "never"] = setting(
        "always", "whether TPDO1 to 3 are sent on entering Operational", assumed="A-15"
    )
    arm: Literal["heartbeat", "operational"] = setting(
        "heartbeat", "what the monitoring of the partner begins with", assumed="A-19"
    )

    busy_request: Literal["waits", "overwrites"] = setting(
        "waits",
        "an SDO request while others are answered: the 33rd that would wait is an overflow",
        assumed="A-60",
    )

    # the engine
    load: float = setting(0.0, "what the consumers draw", unit="kW", live=True, low=0)
    run: bool = setting(
        False,
        "the start switch; the engine starts when it is turned on",
        assumed="A-53",
        live=True,
    )
    autostart: bool = setting(
        False,
        "the engine starts by itself while the switch is on: after power-on and after an error",
        assumed="A-53",
        live=True,
    )
    breaker_speed: float = setting(
        1425.0,
        "speed at which the generator breaker lets the consumers on; it opens at 0.7 of it",
        unit="rpm",
        assumed="A-55",
        live=True,
        low=0,
    )
    speed: float = setting(
        1500.0,
        "setpoint without a valid one by CANopen",
        unit="rpm",
        assumed="A-47",
        live=True,
        low=0,
    )
    highest_speed: float = setting(
        1800.0,
        "what an external setpoint of 100 % means, and the end of every other",
        unit="rpm",
        assumed="A-56",
        live=True,
        low=700,
        high=3800,
    )
    overspeed: float = setting(
        2070.0,
        "speed above which the engine is stopped",
        unit="rpm",
        assumed="A-56",
        live=True,
        low=0,
        high=4000,
    )
    speed_noise: float | None = setting(
        None,
        "of the measured speed while it turns, up and down; none: 0, 1 or 4 by `timing`",
        unit="rpm",
        assumed="A-59",
        low=0,
    )
    droop: float = setting(
        0.0, "fall of speed up to rated load", unit="%", assumed="A-47", live=True, low=0, high=20
    )
