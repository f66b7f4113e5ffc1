"""What a charger shows over time: its outputs beside the setpoints, sparks, and its release."""

from collections.abc import Mapping

from canopen_twins.device import Band, Chart, Curve, Mood
from canopen_twins.devices.charger.model.charger import Charger
from canopen_twins.devices.charger.model.parameters import Parameter
from canopen_twins.devices.charger.model.release import ReleaseState
from canopen_twins.devices.charger.model.types import Quantity

KILO, MICRO = 1e3, 1e6
BANDS: Mapping[ReleaseState, Band] = {
    ReleaseState.LOCKED: Band("locked", Mood.OFF),
    ReleaseState.ARMED: Band("armed", Mood.WAITING),
    ReleaseState.ON: Band("high voltage on", Mood.ACTIVE),
    ReleaseState.FAULT: Band("fault", Mood.ERROR),
}


def chart(charger: Charger) -> Chart:
    """The discharging voltage as well, if the variant has one."""
    output, discharging = charger.charging.output, charger.discharging

    def setpoint(quantity: Quantity) -> float:
        return charger.charging.setpoints(charger.surroundings.analog)[quantity]

    def discharging_setpoint() -> float:
        return charger.parameters[Parameter.VOLTAGE_SETPOINT_DISCHARGING] / KILO

    curves = [
        Curve(
            "Voltage",
            "kV",
            lambda: output.voltage / KILO,
            lambda: setpoint(Quantity.VOLTAGE) / KILO,
        ),
        Curve("Current", "µA", lambda: output.current * MICRO, lambda: setpoint(Quantity.CURRENT)),
        Curve("Discharging", "kV", lambda: discharging.now.voltage / KILO, discharging_setpoint),
        Curve("Sparks", "", lambda: sum(charger.charging.sparks.counts.values())),
    ]
    if not charger.build.discharges:
        del curves[2]
    return Chart(curves, lambda: BANDS[charger.release.state])
