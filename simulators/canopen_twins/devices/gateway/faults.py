"""What can go wrong with both units, with what joins them, and around them: a row for each fault.

A row acts on the device. It asks for the system when it is used: power-on makes a new one.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

from canopen_twins.device.faults import Fault, Parameter
from canopen_twins.devices.gateway.model.configuration import PARTNER_NODE, RPDOS
from canopen_twins.devices.gateway.model.heinzmann_can import Direction
from canopen_twins.devices.gateway.model.parameters import Unit
from canopen_twins.devices.gateway.model.system import Buffer
from canopen_twins.devices.gateway.model.timing import MILLISECOND
from canopen_twins.devices.gateway.unit_faults import UNIT_FAULTS, one_of, positive
from canopen_twins.errors import UserError

if TYPE_CHECKING:
    from canopen_twins.devices.gateway import Device


DIRECTIONS = {
    "both": tuple(Unit),
    "to_gateway": (Unit.GATEWAY,),
    "to_governor": (Unit.GOVERNOR,),
}
DIRECTION = {"direction": Parameter(", ".join(DIRECTIONS), "both", str)}
TPDO5, TPDO5_CYCLE, TPDO5_IDENTIFIER = 16404, 16461, 16404
TPDO6, TPDO6_CYCLE, TPDO6_IDENTIFIER = 16408, 16462, 16405
SPEED = 2000  # something to send
FREE_IDENTIFIER = 0x3E5
USUAL_DELAY = Direction.delay // MILLISECOND
SENT = {TPDO5: SPEED, TPDO5_CYCLE: 100}
TWICE = {
    "governor": {**SENT, TPDO6: SPEED, TPDO6_CYCLE: 100},
    "gateway": {TPDO5_IDENTIFIER: FREE_IDENTIFIER, TPDO6_IDENTIFIER: FREE_IDENTIFIER},
}


def faults(device: Device) -> Mapping[str, Fault]:
    """Every fault by its name, of this device."""

    def bound(fault: Fault) -> Fault:
        clear = None if fault.clear is None else partial(fault.clear, device)
        return replace(fault, inject=partial(fault.inject, device), clear=clear)

    return {name: bound(fault) for name, fault in {**UNIT_FAULTS, **FAULTS}.items()}


def _within(known: range, what: str, number: int) -> int:
    if number not in known:
        raise UserError(f"{what} {number} is not in {known[0]}..{known[-1]}")
    return number


def _directions(device: Device, direction: str) -> list[Direction]:
    units = DIRECTIONS[one_of(DIRECTIONS, "direction", direction)]
    return [device.system.link.to[unit] for unit in units]


def _cut(device: Device, direction: str, cut: bool = True) -> None:
    for each in _directions(device, direction):
        each.cut = cut


def _delay(device: Device, milliseconds: int, direction: str) -> None:
    delay = _within(range(1, 1001), "milliseconds", milliseconds) * MILLISECOND
    for each in _directions(device, direction):
        each.delay = delay


def _drop(device: Device, count: int, direction: str) -> None:
    for each in _directions(device, direction):
        each.drop = count


def _overflow(buffer: Buffer, consequence: str) -> Fault:
    text = f"The buffer for {buffer.value} overflows, once ({consequence})."
    return Fault(text, lambda device: device.system.overflow(buffer))


def _disturb(device: Device, fault: bool = True) -> None:
    device.system.gateway.plug.fault = fault


def _lose_partner(device: Device, lost: bool = True) -> None:
    device.disturbance.partner = lost


def _flag(device: Device, channel: int) -> None:
    device.disturbance.flags = 1 << (_within(range(1, 13), "channel", channel) - 1)


def _unflag(device: Device, channel: int) -> None:
    device.disturbance.flags = 0


def _misconfigured(
    text: str,
    content: Callable[..., Mapping[str, Mapping[int, float]]],
    parameters: Mapping[str, Parameter] | None = None,
) -> Fault:
    return Fault(
        text,
        lambda device, **given: device.nonvolatile.misconfigure(content(device, **given)),
        lambda device, **_: device.nonvolatile.put_right(),
        parameters or {},
    )


def _race(device: Device, rpm: int) -> None:
    device.system.governor.engine.speed = positive("rpm", rpm)


FAULTS: Mapping[str, Fault] = {
    # between the units
    "link_cut": Fault(
        "The HEINZMANN CAN between the units is cut (3071 after 500 ms).",
        _cut,
        partial(_cut, cut=False),
        DIRECTION,
    ),
    "link_delay": Fault(
        "Telegrams between the units take longer.",
        _delay,
        lambda device, milliseconds, direction: _delay(device, USUAL_DELAY, direction),
        {"milliseconds": Parameter("how long, 1..1000", kind=int), **DIRECTION},
    ),
    "link_drop": Fault(
        "The next telegrams between the units are lost.",
        lambda device, count, direction: _drop(device, int(positive("count", count)), direction),
        lambda device, count, direction: _drop(device, 0, direction),
        {"count": Parameter("how many", 1, int), **DIRECTION},
    ),
    # CANopen
    "can2_bus_fault": Fault(
        "The CANopen bus is disturbed (3072, 12423).", _disturb, partial(_disturb, fault=False)
    ),
    "can1_receive_overflow": _overflow(Buffer.CAN1_RECEIVE, "3071 and 12422 in the gateway"),
    "can2_receive_overflow": _overflow(Buffer.CAN2_RECEIVE, "3073 and 12424: initialised again"),
    "sdo_transmit_overflow": _overflow(Buffer.SDO_TRANSMIT, "3073 and 12424: Stopped"),
    "partner_lost": Fault(
        "Heartbeats of node 428 do not arrive (12420 if they are monitored).",
        _lose_partner,
        partial(_lose_partner, lost=False),
    ),
    "rpdo_lost": Fault(
        "An RPDO does not arrive (12413 if it is monitored).",
        lambda device, number: device.disturbance.lost.add(_within(RPDOS, "number", number)),
        lambda device, number: device.disturbance.lost.discard(number),
        {"number": Parameter("1..4", 1, int)},
    ),
    "sensor_flag": Fault(
        "The flag of a sensor is set in word 3 of RPDO1 (its error 3005 onward).",
        _flag,
        _unflag,
        {"channel": Parameter("1..12", 1, int)},
    ),
    # the configuration
    "duplicate_identifier": _misconfigured(
        "TPDO5 and TPDO6 are configured with one identifier; both units restart (12412).",
        lambda device: TWICE,
    ),
    "reserved_identifier": _misconfigured(
        "TPDO5 is configured with an identifier of others; both units restart (12412).",
        lambda device, identifier: {"governor": SENT, "gateway": {TPDO5_IDENTIFIER: identifier}},
        {"identifier": Parameter("of TPDO5", 0x100, int)},
    ),
    "partner_is_own_node": _misconfigured(
        "428 is the own node id; both units restart (12412).",
        lambda device: {"gateway": {PARTNER_NODE: device.node_id}},
    ),
    # the engine
    "load_step": Fault(
        "Consumers are switched on, beside those of the setting `load`.",
        lambda device, kilowatts: device.step_load(kilowatts),
        lambda device, kilowatts: device.step_load(0),
        {"kilowatts": Parameter("how much they draw", 100.0)},
    ),
    "overspeed": Fault(
        "The engine is too fast for a moment: stopped until the errors are cleared (3004).",
        _race,
        parameters={"rpm": Parameter("how fast; above 1725 rpm it is stopped", 1750, int)},
    ),
}
