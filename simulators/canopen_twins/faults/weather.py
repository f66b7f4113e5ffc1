"""In which weather each fault that every device has is to be expected, and why.

Mild is any week of a healthy installation, rough a bad day of one that has been built as it should,
hostile what nobody may promise a master: devices with bugs that the CRC of the bus does not show,
and mistakes of whoever has installed them.
"""

from collections.abc import Mapping

from canopen_twins.device.faults import Weather

BUSY = Weather("mild", "a device or a bus that is busy")
GLITCH = Weather("mild", "a disturbed line loses a frame now and then")
REFUSAL = Weather("mild", "CiA 301 lets a server refuse for reasons of its own")
SUPPLY = Weather("rough", "plugs, fuses and operators")
HANG = Weather("rough", "firmware that hangs, or is reset by its watchdog")
LINE = Weather("rough", "a cable or a controller that fails, and comes back")
SERVER = Weather("rough", "a server with a bug that the protocol lets every client notice")
FORGED = Weather("hostile", "behind the CRC: a bug of the device that the protocol does not show")
INSTALLED = Weather("hostile", "a mistake of the installation, which does not heal by itself")

WEATHER: Mapping[str, Weather] = {
    "sdo_abort": REFUSAL,
    "sdo_silence": GLITCH,
    "sdo_late": BUSY,
    "sdo_wrong_index": SERVER,
    "sdo_wrong_toggle": SERVER,
    "sdo_wrong_size": SERVER,
    "sdo_stall": HANG,
    "sdo_in_wrong_state": FORGED,
    "pdo_frozen": FORGED,
    "pdo_missing": GLITCH,
    "pdo_short": FORGED,
    "pdo_wrong_cob_id": FORGED,
    "pdo_jitter": BUSY,
    "emcy_storm": HANG,
    "emcy_lost": GLITCH,
    "emcy_doubled": GLITCH,
    "heartbeat_stopped": HANG,
    "heartbeat_jitter": BUSY,
    "heartbeat_late": BUSY,
    "heartbeat_wrong_state": FORGED,
    "boot_up_lost": GLITCH,
    "boot_up_repeated": HANG,
    "reset_loop": HANG,
    "power_cycle": SUPPLY,
    "brown_out": SUPPLY,
    "duplicate_node_id": INSTALLED,
    "wrong_identity": INSTALLED,
    "wrong_firmware": INSTALLED,
    "frame_lost": GLITCH,
    "frame_doubled": GLITCH,
    "frame_late": BUSY,
    "frame_jitter": BUSY,
    "frame_swapped": FORGED,
    "frame_corrupt": FORGED,
    "error_passive": LINE,
    "bus_off": LINE,
    "bus_load": BUSY,
}
