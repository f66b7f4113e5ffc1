"""What can go wrong with both units, with what joins them, and around them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from canopen_twins.device.faults import Fault, Parameter
from canopen_twins.devices.gateway.model.link import Direction
from canopen_twins.devices.gateway.model.parameters import Unit
from canopen_twins.devices.gateway.model.system import Buffer
from canopen_twins.devices.gateway.model.timing import MILLISECOND
from canopen_twins.devices.gateway.unit_faults import (
    faults_by_error,
    faults_of_bootloaders,
    faults_of_units,
    one_of,
    positive,
)
from canopen_twins.errors import UserError

if TYPE_CHECKING:
    from canopen_twins.devices.gateway import Device


DIRECTIONS = {
    "both": tuple(Unit),
    "to_gateway": (Unit.GATEWAY,),
    "to_governor": (Unit.GOVERNOR,),
}
DIRECTION = {"direction": Parameter(", ".join(DIRECTIONS), "both", str)}
RPDOS, CHANNELS = range(1, 5), range(1, 13)
TPDO5, TPDO5_CYCLE, TPDO5_IDENTIFIER = 16404, 16461, 16404
TPDO6, TPDO6_CYCLE, TPDO6_IDENTIFIER = 16408, 16462, 16405
SPEED = 2000  # something to send
FREE_IDENTIFIER = 0x3E5


def faults(device: Device) -> Mapping[str, Fault]:
    """Every fault by its name.

    The device is asked for its system when a fault is used: power-on makes a new one.
    """
    return {
        **faults_of_units(device),
        **faults_by_error(device),
        **faults_of_bootloaders(device),
        **_link(device),
        **_canopen(device),
        **_rpdos(device),
        **_configuration(device),
        **_engine(device),
    }


def _link(device: Device) -> Mapping[str, Fault]:
    def each(direction: str, **fields: int) -> None:
        for unit in DIRECTIONS[one_of(DIRECTIONS, "direction", direction)]:
            for name, value in fields.items():
                setattr(device.system.link.to[unit], name, value)

    return {
        "link_cut": Fault(
            "The HEINZMANN CAN between the units is cut (3071 after 500 ms).",
            lambda direction: each(direction, cut=True),
            lambda direction: each(direction, cut=False),
            DIRECTION,
        ),
        "link_delay": Fault(
            "Telegrams between the units take longer.",
            lambda milliseconds, direction: each(direction, delay=_delay(milliseconds)),
            lambda milliseconds, direction: each(direction, delay=Direction.delay),
            {"milliseconds": Parameter("how long, 1..1000", kind=int), **DIRECTION},
        ),
        "link_drop": Fault(
            "The next telegrams between the units are lost.",
            lambda count, direction: each(direction, drop=int(positive("count", count))),
            lambda count, direction: each(direction, drop=0),
            {"count": Parameter("how many", 1, int), **DIRECTION},
        ),
    }


def _canopen(device: Device) -> Mapping[str, Fault]:
    overflows = {
        "can1_receive_overflow": (Buffer.CAN1_RECEIVE, "3071 and 12422 in the gateway"),
        "can2_receive_overflow": (Buffer.CAN2_RECEIVE, "3073 and 12424: initialised again"),
        "sdo_transmit_overflow": (Buffer.SDO_TRANSMIT, "3073 and 12424: Stopped"),
    }
    return {
        "can2_bus_fault": Fault(
            "The CANopen bus is disturbed (3072, 12423).",
            lambda: setattr(device.system.gateway.plug, "fault", True),
            lambda: setattr(device.system.gateway.plug, "fault", False),
        ),
        **{name: _overflow(device, *told) for name, told in overflows.items()},
        "partner_lost": Fault(
            "Heartbeats of node 428 do not arrive (12420 if they are monitored).",
            lambda: setattr(device.disturbance, "partner", True),
            lambda: setattr(device.disturbance, "partner", False),
        ),
    }


def _rpdos(device: Device) -> Mapping[str, Fault]:
    def lose(number: int) -> None:
        device.disturbance.lost.add(_within(RPDOS, "number", number))

    def find(number: int) -> None:
        device.disturbance.lost.discard(number)

    def flag(channel: int) -> None:
        device.disturbance.flags = 1 << (_within(CHANNELS, "channel", channel) - 1)

    def unflag(channel: int) -> None:
        device.disturbance.flags = 0

    return {
        "rpdo_lost": Fault(
            "An RPDO does not arrive (12413 if it is monitored).",
            lose,
            find,
            {"number": Parameter("1..4", 1, int)},
        ),
        "sensor_flag": Fault(
            "The flag of a sensor is set in word 3 of RPDO1 (its error 3005 onward).",
            flag,
            unflag,
            {"channel": Parameter("1..12", 1, int)},
        ),
    }


def _overflow(device: Device, buffer: Buffer, consequence: str) -> Fault:
    text = f"The buffer for {buffer.value} overflows, once ({consequence})."
    return Fault(text, lambda: device.system.overflow(buffer))


def _configuration(device: Device) -> Mapping[str, Fault]:
    sent = {TPDO5: SPEED, TPDO5_CYCLE: 100}
    twice = {
        "governor": {**sent, TPDO6: SPEED, TPDO6_CYCLE: 100},
        "gateway": {TPDO5_IDENTIFIER: FREE_IDENTIFIER, TPDO6_IDENTIFIER: FREE_IDENTIFIER},
    }
    return {
        "duplicate_identifier": Fault(
            "TPDO5 and TPDO6 are configured with one identifier; both units restart (12412).",
            lambda: device.nonvolatile.misconfigure(twice),
            lambda: device.nonvolatile.put_right(),  # noqa: PLW0108 - of the system by then
        ),
        "reserved_identifier": Fault(
            "TPDO5 is configured with an identifier of others; both units restart (12412).",
            lambda identifier: device.nonvolatile.misconfigure(
                {"governor": sent, "gateway": {TPDO5_IDENTIFIER: identifier}}
            ),
            lambda identifier: device.nonvolatile.put_right(),
            {"identifier": Parameter("of TPDO5", 0x100, int)},
        ),
        "partner_is_own_node": Fault(
            "428 is the own node id; both units restart (12412).",
            lambda: device.nonvolatile.misconfigure({"gateway": {428: device.node_id}}),
            lambda: device.nonvolatile.put_right(),  # noqa: PLW0108 - of the system by then
        ),
    }


def _engine(device: Device) -> Mapping[str, Fault]:
    return {
        "load_step": Fault(
            "Consumers are switched on, beside those of the setting `load`.",
            device.step_load,
            lambda kilowatts: device.step_load(0),
            {"kilowatts": Parameter("how much they draw", 100.0)},
        ),
        "overspeed": Fault(
            "The engine is too fast for a moment: stopped until the errors are cleared (3004).",
            lambda rpm: setattr(device.system.governor.engine, "speed", positive("rpm", rpm)),
            parameters={"rpm": Parameter("how fast; above 1725 rpm it is stopped", 1750, int)},
        ),
    }


def _delay(milliseconds: int) -> int:
    return _within(range(1, 1001), "milliseconds", milliseconds) * MILLISECOND


def _within(known: range, what: str, number: int) -> int:
    if number not in known:
        raise UserError(f"{what} {number} is not in {known[0]}..{known[-1]}")
    return number
