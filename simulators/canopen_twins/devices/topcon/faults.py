"""What can go wrong with a TopCon: causes with their physics, and every message of chapter 8."""

from collections.abc import Callable, Collection, Mapping

from canopen_twins.device import Fault, Parameter
from canopen_twins.devices.topcon.messages import card_error, unit_error
from canopen_twins.devices.topcon.model.protections import RAILS
from canopen_twins.devices.topcon.model.stage import OutputStage
from canopen_twins.errors import UserError, unknown

SENSORS: Mapping[str, int] = {"rectifier": 0x50, "igbt": 0x51, "inside": 0x55}  # Tab. 71
MAINS = range(100, 601)
NUMBER = {
    "number": Parameter(
        "error number of chapter 8, 0x00..0x1ff", kind=int, examples=(0x23, 0x31, 0x50, 0x67)
    )
}


def faults(stage: OutputStage, raise_card_error: Callable[[int], None]) -> Mapping[str, Fault]:
    """Every fault by its name, of this unit and of the card that sits in it."""
    return {**_connections(stage), **_supplies(stage), **_errors(stage, raise_card_error)}


def _connections(stage: OutputStage) -> dict[str, Fault]:
    """What is wrong with the cables of the unit."""
    return {
        "interlock_open": Fault(
            "The interlock opens: off at once, no RUN, no reset until it closes (EMCY 9000, F2).",
            lambda: _interlock(stage, closed=False),
            lambda: _interlock(stage, closed=True),
        ),
        "slave_silent": Fault(
            "A slave of the multi-unit system does not answer (EMCY 8100, 67).",
            lambda: _slave(stage, silent=True),
            lambda: _slave(stage, silent=False),
        ),
        "sense_reversed": Fault(
            "The sense lines are swapped (EMCY 3300, 33).",
            lambda: _sense_lines(stage, swapped=True),
            lambda: _sense_lines(stage, swapped=False),
        ),
        "sense_offset": Fault(
            "The voltage at the sense lines differs from that at the terminals (EMCY 3300, 31).",
            lambda volts: _sense(stage, volts),
            lambda volts: _sense(stage, OutputStage.sense_offset),
            {
                "volts": Parameter(
                    "difference in V; 5 % of the nominal voltage are tolerated",
                    examples=(30.0, 5.0),
                )
            },
        ),
    }


def _supplies(stage: OutputStage) -> dict[str, Fault]:
    """What leaves the range in which the unit works."""
    return {
        "mains": Fault(
            "The mains leave 340..460 V (EMCY 3200, 49, 4A, 4D); with IBC also 48..62 Hz"
            " (3100, 145, 144, 143, 142).",
            lambda volts, hertz, seconds: _feed(stage, _mains(volts), hertz, seconds),
            lambda volts, hertz, seconds: _feed(
                stage, OutputStage.mains, OutputStage.mains_frequency, seconds
            ),
            {
                "volts": Parameter(
                    "between the phases, 100..600 V", OutputStage.mains, examples=(300.0, 500.0)
                ),
                "hertz": Parameter("40..70 Hz", OutputStage.mains_frequency, low=40, high=70),
                "seconds": Parameter("until they are there, and until they are back", 0.0, low=0),
            },
        ),
        "supply": Fault(
            "A supply inside the unit leaves its range of 10 % (EMCY 3200, 43..48, 4B, 4C).",
            lambda rail, volts: _supply(stage, {_one_of(RAILS, "rail", rail): volts}),
            lambda rail, volts: _supply(stage, {}),
            {
                "rail": Parameter(", ".join(RAILS), kind=str, examples=tuple(RAILS)),
                "volts": Parameter("its voltage in V", examples=(0.0,)),
            },
        ),
        "overtemperature": Fault(
            "A temperature sensor is above its limit (EMCY 4200).",
            lambda sensor: stage.trip(SENSORS[_one_of(SENSORS, "sensor", sensor)], held=True),
            lambda sensor: stage.release(SENSORS[sensor]),
            {"sensor": Parameter(", ".join(SENSORS), "igbt", str, examples=tuple(SENSORS))},
        ),
    }


def _errors(stage: OutputStage, raise_card_error: Callable[[int], None]) -> dict[str, Fault]:
    """Messages of chapter 8 without a cause of their own."""
    return {
        "error": Fault(
            "Any error of the unit; its cause is gone at once, the error stays until the reset.",
            lambda number: stage.trip(unit_error(number)),
            parameters=NUMBER,
        ),
        "lasting_error": Fault(
            "Any error of the unit; its cause lasts until the fault is cleared.",
            lambda number: stage.trip(unit_error(number), held=True),
            lambda number: stage.release(unit_error(number)),
            NUMBER,
        ),
        "card_error": Fault(
            "An error of the CAN card: told, but the output goes on.",
            lambda code: raise_card_error(card_error(code)),
            parameters={
                "code": Parameter(
                    "0x5000, 0x8110, 0x8111, 0x8112 or 0x8200", kind=int, examples=(0x5000, 0x8110)
                )
            },
        ),
        "warning": Fault(
            "A warning of the unit: bit 14 of 0x2023 until the reset, no EMCY.",
            stage.warn,
        ),
    }


def _one_of(known: Collection[str], what: str, word: str) -> str:
    if word not in known:
        raise unknown(what, word, known)
    return word


def _interlock(stage: OutputStage, closed: bool) -> None:
    stage.interlock_closed = closed


def _slave(stage: OutputStage, silent: bool) -> None:
    stage.slave_silent = silent


def _sense_lines(stage: OutputStage, swapped: bool) -> None:
    stage.sense_reversed = swapped


def _sense(stage: OutputStage, volts: float) -> None:
    stage.sense_offset = volts


def _supply(stage: OutputStage, supplies: Mapping[str, float]) -> None:
    stage.supplies = supplies


def _feed(stage: OutputStage, volts: float, hertz: float, seconds: float) -> None:
    stage.mains_frequency, stage.mains_goal = hertz, volts
    stage.mains_slew = abs(volts - stage.mains) / seconds if seconds else 0.0
    if not seconds:
        stage.mains = volts


def _mains(volts: float) -> float:
    if not MAINS[0] <= volts <= MAINS[-1]:
        raise UserError(f"mains of {volts} V: 100..600 V; without mains the unit is off")
    return volts
