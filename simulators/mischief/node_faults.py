"""Node level: heartbeat, boot-up, supply and identity of one node go wrong."""

from collections.abc import Mapping

from simulators.faults import Parameter
from simulators.frame import Frame
from simulators.mischief.disturbance import Filtering, Kind
from simulators.mischief.effects import altered, jittered, late, lost, repeated
from simulators.mischief.identity import Firmware, Identity
from simulators.mischief.supply import Duplicate, ResetLoop, Supply
from simulators.mischief.turn import AIM, Turn
from simulators.node import Node

BOOT_UP = b"\0"
SECONDS = Parameter("by how much, in s", 1.0, low=0)
PERIOD = Parameter("from one to the next, in s", 1.0, low=1e-6)


def is_heartbeat(node: Node, frame: Frame) -> bool:
    """Whether a frame is a heartbeat of a node; the boot-up message is none."""
    return _is_error_control(node, frame) and frame.data != BOOT_UP


def is_boot_up(node: Node, frame: Frame) -> bool:
    """Whether a frame is the boot-up message of a node."""
    return _is_error_control(node, frame) and frame.data == BOOT_UP


def _is_error_control(node: Node, frame: Frame) -> bool:
    return frame.can_id == 0x700 + node.node_id and not frame.remote


HEARTBEAT: Mapping[str, Kind] = {
    "heartbeat_stopped": Kind(
        "Heartbeats do not come; the node goes on.",
        "A heartbeat event: the node counts as lost, although it answers.",
        AIM,
        lambda place, **turn: Filtering(place.node, is_heartbeat, lost, Turn(**turn)),
    ),
    "heartbeat_late": Kind(
        "Heartbeats come late.",
        "One gap of a period more; whether it is a loss is for the consumer time to say.",
        {"seconds": SECONDS, **AIM},
        lambda place, seconds, **turn: Filtering(
            place.node, is_heartbeat, late(seconds), Turn(**turn)
        ),
    ),
    "heartbeat_jitter": Kind(
        "Heartbeats come late, each by another time; none overtakes another.",
        "Irregular heartbeats: no event as long as the consumer time is kept.",
        {"seconds": Parameter("at most by how much, in s", 0.1, low=0), **AIM},
        lambda place, seconds, **turn: Filtering(
            place.node,
            is_heartbeat,
            jittered(place.node.clock, seconds, turn["seed"]),
            Turn(**turn),
        ),
    ),
    "heartbeat_wrong_state": Kind(
        "Heartbeats show another state than the node is in.",
        "A state it did not command: an alarm, and a new NMT command.",
        {
            "state": Parameter(
                "0x04 stopped, 0x05 operational, 0x7f pre-operational, or any byte",
                0x04,
                int,
                low=0,
                high=0xFF,
            ),
            **AIM,
        },
        lambda place, state, **turn: Filtering(
            place.node, is_heartbeat, altered(lambda _: bytes([state])), Turn(**turn)
        ),
    ),
}

BOOT: Mapping[str, Kind] = {
    "boot_up_lost": Kind(
        "The boot-up message does not come.",
        "A node that is there without having said so: to be found by reading 0x1000.",
        AIM,
        lambda place, **turn: Filtering(place.node, is_boot_up, lost, Turn(**turn)),
    ),
    "boot_up_repeated": Kind(
        "The boot-up message comes several times, although the node boots once.",
        "A node that seems to boot again: to be configured again, and no endless loop.",
        {
            "repeats": Parameter("how many times more", 1, int, low=1),
            "seconds": PERIOD,
            **AIM,
        },
        lambda place, repeats, seconds, **turn: Filtering(
            place.node, is_boot_up, repeated(repeats, seconds), Turn(**turn)
        ),
    ),
    "reset_loop": Kind(
        "The watchdog resets the node again and again.",
        "A boot-up after the other, the parameters gone: to be given up after some attempts.",
        {"seconds": PERIOD, "times": Parameter("how many resets; 0: no end", 0, int, low=0)},
        ResetLoop,
    ),
    "power_cycle": Kind(
        "The supply goes, and comes back.",
        "Silence, then a boot-up without a command: to be configured and started anew.",
        {"seconds": Parameter("without supply, in s", 1.0, low=1e-6)},
        lambda place, seconds: Supply(place, seconds, 0.0, 1),
    ),
    "brown_out": Kind(
        "The supply fails several times in a row.",
        "Boot-ups in a row; some of its configuration falls into a gap and has to be repeated.",
        {
            "seconds": Parameter("without supply, in s", 0.05, low=1e-6),
            "pause": Parameter("with supply in between, in s", 0.2, low=1e-6),
            "times": Parameter("how many times", 3, int, low=1),
        },
        Supply,
    ),
}

WHO: Mapping[str, Kind] = {
    "duplicate_node_id": Kind(
        "A second device of the same kind and node id is on the bus, as it is delivered.",
        "Two boot-ups, two heartbeats, two answers to each request: an error of the installation.",
        {},
        Duplicate,
    ),
    "wrong_identity": Kind(
        "The identity object 0x1018 has another value.",
        "Another device than it was told to expect: not to be started (CiA 302-2, boot-up).",
        {
            "entry": Parameter("1 vendor, 2 product, 3 revision, 4 serial", 2, int, 1, 4),
            "value": Parameter("its value", 0xBAD, int, low=0, high=0xFFFF_FFFF),
        },
        Identity,
    ),
    "wrong_firmware": Kind(
        "The software version 0x100A is another one.",
        "A version it does not know: to be reported, or refused.",
        {"version": Parameter("its text", "0.0", str)},
        Firmware,
    ),
}

NODE: Mapping[str, Kind] = {**HEARTBEAT, **BOOT, **WHO}
