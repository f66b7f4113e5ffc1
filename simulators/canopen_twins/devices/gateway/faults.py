"""What can go wrong with both units, with what joins them, and around them: a row for each fault.

A row acts on the units. It asks for the system when it is used: power-on makes a new one.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial

from canopen_twins.device.faults import Fault, Parameter, Weather
from canopen_twins.devices.gateway.model.buffers import Buffer
from canopen_twins.devices.gateway.model.configuration import PARTNER_NODE, RPDOS
from canopen_twins.devices.gateway.model.heinzmann_can import Direction
from canopen_twins.devices.gateway.model.parameters import Unit
from canopen_twins.devices.gateway.model.timing import MILLISECOND
from canopen_twins.devices.gateway.unit_faults import UNIT_FAULTS, one_of, positive
from canopen_twins.devices.gateway.units import Units
from canopen_twins.errors import UserError

CHANNELS = range(1, 13)
DIRECTIONS = {
    "both": tuple(Unit),
    "to_gateway": (Unit.GATEWAY,),
    "to_governor": (Unit.GOVERNOR,),
}
DIRECTION = {"direction": Parameter(", ".join(DIRECTIONS), "both", str, examples=tuple(DIRECTIONS))}
HEALS = {"direction": DIRECTION["direction"]._replace(examples=("both", "to_governor"))}
"""Not `to_gateway`: amid the handshake it leaves 12412 until somebody clears it (9.5)."""
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


INSTALLED = ("duplicate_number", "duplicate_identifier", "reserved_identifier")
WEATHER = {
    **dict.fromkeys(
        (*INSTALLED, "partner_is_own_node"),
        Weather("hostile", "a mistake of whoever has configured it"),
    ),
    "eeprom": Weather("hostile", "a broken memory has to be repaired"),
    **dict.fromkeys(
        ("error", "exception", "bootloader", "watchdog", "endless_loop"),
        Weather("hostile", "stays until somebody clears it with DcDesk, or for good (9.1, 9.3)"),
    ),
    **dict.fromkeys(
        ("overspeed", "oil_lost", "cooling_lost", "fuel_lost"),
        Weather("hostile", "stops the engine until somebody clears the errors with DcDesk (9.1)"),
    ),
    **dict.fromkeys(
        ("link_delay", "link_drop"),
        Weather("hostile", "three failed attempts leave 12412 until somebody clears it (9.5)"),
    ),
}


def faults(units: Units) -> Mapping[str, Fault]:
    """Every fault by its name, of this units."""

    def bound(name: str, fault: Fault) -> Fault:
        clear = None if fault.clear is None else partial(fault.clear, units)
        weather = WEATHER.get(name, fault.weather)
        return replace(fault, inject=partial(fault.inject, units), clear=clear, weather=weather)

    return {name: bound(name, fault) for name, fault in {**UNIT_FAULTS, **FAULTS}.items()}


def _within(known: range, what: str, number: int) -> int:
    if number not in known:
        raise UserError(f"{what} {number} is not in {known[0]}..{known[-1]}")
    return number


def _directions(units: Units, direction: str) -> list[Direction]:
    to = DIRECTIONS[one_of(DIRECTIONS, "direction", direction)]
    return [units.system.link.to[unit] for unit in to]


def _cut(units: Units, direction: str, cut: bool = True) -> None:
    for each in _directions(units, direction):
        each.cut = cut


def _delay(units: Units, milliseconds: int, direction: str) -> None:
    delay = _within(range(1, 1001), "milliseconds", milliseconds) * MILLISECOND
    for each in _directions(units, direction):
        each.delay = delay


def _drop(units: Units, count: int, direction: str) -> None:
    for each in _directions(units, direction):
        each.drop = count


def _overflow(buffer: Buffer, consequence: str) -> Fault:
    text = f"The buffer for {buffer.value} overflows, once ({consequence})."
    return Fault(text, lambda units: units.system.overflow(buffer))


def _disturb(units: Units, fault: bool = True) -> None:
    units.system.gateway.plug.fault = fault


def _lose_partner(units: Units, lost: bool = True) -> None:
    units.disturbance.partner = lost


def _misconfigured(
    text: str,
    content: Callable[..., Mapping[str, Mapping[int, float]]],
    parameters: Mapping[str, Parameter] | None = None,
) -> Fault:
    return Fault(
        text,
        lambda units, **given: units.misconfigure(content(units, **given)),
        lambda units, **_: units.put_right(),
        parameters or {},
    )


def _lose_oil(units: Units, percent: float = 0.0) -> None:
    if not 0 <= percent <= 100:
        raise UserError(f"percent {percent:g} is not in 0..100")
    units.system.governor.engine.oil_lost = percent / 100


def _lose_cooling(units: Units, kelvin: float = 0.0) -> None:
    units.system.governor.engine.cooling_lost = kelvin


def _lose_fuel(units: Units, lost: bool = True) -> None:
    units.system.governor.engine.fuel_cut = lost


def _race(units: Units, rpm: int) -> None:
    units.system.governor.engine.speed = positive("rpm", rpm)


FAULTS: Mapping[str, Fault] = {
    # between the units
    "link_cut": Fault(
        "The HEINZMANN CAN between the units is cut (3071 after 500 ms).",
        _cut,
        partial(_cut, cut=False),
        HEALS,
    ),
    "link_delay": Fault(
        "Telegrams between the units take longer.",
        _delay,
        lambda units, milliseconds, direction: _delay(units, USUAL_DELAY, direction),
        {"milliseconds": Parameter("how long, 1..1000", kind=int, examples=(50, 500)), **DIRECTION},
    ),
    "link_drop": Fault(
        "The next telegrams between the units are lost.",
        lambda units, count, direction: _drop(units, int(positive("count", count)), direction),
        lambda units, count, direction: _drop(units, 0, direction),
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
        lambda units, number: units.disturbance.lost.add(_within(RPDOS, "number", number)),
        lambda units, number: units.disturbance.lost.discard(number),
        {"number": Parameter("1..4", 1, int)},
    ),
    "sensor_flag": Fault(
        "The flag of a sensor is set in word 3 of RPDO1 (its error 3005 onward).",
        lambda units, channel: units.disturbance.flagged.add(_within(CHANNELS, "channel", channel)),
        lambda units, channel: units.disturbance.flagged.discard(channel),
        {"channel": Parameter("1..12", 1, int)},
    ),
    # the configuration
    "duplicate_identifier": _misconfigured(
        "TPDO5 and TPDO6 are configured with one identifier; both units restart (12412).",
        lambda units: TWICE,
    ),
    "reserved_identifier": _misconfigured(
        "TPDO5 is configured with an identifier of others; both units restart (12412).",
        lambda units, identifier: {"governor": SENT, "gateway": {TPDO5_IDENTIFIER: identifier}},
        {"identifier": Parameter("of TPDO5", 0x100, int)},
    ),
    "partner_is_own_node": _misconfigured(
        "428 is the own node id; both units restart (12412).",
        lambda units: {"gateway": {PARTNER_NODE: units.node_id}},
    ),
    # the engine
    "load_step": Fault(
        "Consumers are switched on, beside those of the setting `load`.",
        lambda units, kilowatts: units.step_load(kilowatts),
        lambda units, kilowatts: units.step_load(0),
        {"kilowatts": Parameter("how much they draw", 100.0)},
    ),
    "overspeed": Fault(
        "The engine is too fast for a moment: stopped until the errors are cleared (3004).",
        _race,
        parameters={"rpm": Parameter("how fast; above 2070 rpm it is stopped", 2100, int)},
    ),
    "oil_lost": Fault(
        "The oil of the engine loses pressure (3030 below 1.5 bar; 3031 below 1 bar: stopped).",
        _lose_oil,
        lambda units, percent: _lose_oil(units),
        {"percent": Parameter("of its pressure", 90.0)},
    ),
    "cooling_lost": Fault(
        "The charge air is not cooled (3032 above 85 degC; 3033 above 100 degC: stopped).",
        _lose_cooling,
        lambda units, kelvin: _lose_cooling(units),
        {"kelvin": Parameter("how much warmer it gets", 90.0)},
    ),
    "fuel_lost": Fault(
        "No fuel comes: the engine stalls (3036), or does not start (3034 after three attempts).",
        _lose_fuel,
        partial(_lose_fuel, lost=False),
    ),
}
