"""What a charger shows over time: its outputs beside the setpoints, sparks, and its release."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from canopen_twins.device.chart import Band, Chart, Curve, Mood
from canopen_twins.devices.charger.model.parameters import Parameter
from canopen_twins.devices.charger.model.release import ReleaseState
from canopen_twins.devices.charger.model.types import Quantity

if TYPE_CHECKING:
    from canopen_twins.devices.charger import Device


KILO, MICRO = 1e3, 1e6

BANDS: Mapping[ReleaseState, Band] = {
    ReleaseState.LOCKED: Band("locked", Mood.OFF),
    ReleaseState.ARMED: Band("armed", Mood.WAITING),
    ReleaseState.ON: Band("high voltage on", Mood.ACTIVE),
    ReleaseState.FAULT: Band("fault", Mood.ERROR),
}


def chart(device: Device) -> Chart:
    """The discharging voltage as well, if the variant has one; power-on makes a new charger."""
    discharging = Curve(
        "Discharging",
        "kV",
        lambda: device.charger.discharging.now.voltage / KILO,
        lambda: device.charger.parameters[Parameter.VOLTAGE_SETPOINT_DISCHARGING] / KILO,
    )
    curves = (
        Curve(
            "Voltage",
            "kV",
            lambda: device.charger.charging.output.voltage / KILO,
            lambda: _setpoint(device, Quantity.VOLTAGE) / KILO,
        ),
        Curve(
            "Current",
            "µA",
            lambda: device.charger.charging.output.current * MICRO,
            lambda: _setpoint(device, Quantity.CURRENT),
        ),
        *(discharging,) * device.build.discharges,
        Curve("Sparks", "", lambda: sum(device.charger.charging.sparks.counts.values())),
    )
    return Chart(curves, lambda: BANDS[device.charger.release.state])


def _setpoint(device: Device, quantity: Quantity) -> float:
    charger = device.charger
    return charger.charging.setpoints(charger.surroundings.analog)[quantity]
