"""Governor, the control unit of type DC: governs the engine, initialises the gateway, has PDOs."""

from collections.abc import Callable, Iterator
from functools import partial
from operator import attrgetter
from typing import Any

from canopen_twins.devices.gateway.model import errors
from canopen_twins.devices.gateway.model.configuration import init_parts, tpdos
from canopen_twins.devices.gateway.model.desk import Desk, measured
from canopen_twins.devices.gateway.model.engine import Engine
from canopen_twins.devices.gateway.model.engine_control import EngineControl
from canopen_twins.devices.gateway.model.errors import OF_GOVERNOR, CanopenError
from canopen_twins.devices.gateway.model.handshake import Handshake, Phase
from canopen_twins.devices.gateway.model.heinzmann_can import (
    Binary,
    ClearErrors,
    GatewayAlive,
    GovernorAlive,
    HeinzmannCan,
    InitReady,
    InitResult,
    RpdoData,
    Telegram,
    TpdoData,
)
from canopen_twins.devices.gateway.model.inputs import Inputs
from canopen_twins.devices.gateway.model.noise import Noise
from canopen_twins.devices.gateway.model.parameters import Unit
from canopen_twins.devices.gateway.model.speed_governor import Operation, SpeedGovernor
from canopen_twins.devices.gateway.model.state import GatewayState
from canopen_twins.devices.gateway.model.timing import NEVER, microseconds
from canopen_twins.devices.gateway.model.unit import ControlUnit, Programme, Surroundings, Tables

SPEED = 2000  # as the pick-up measures it
SERVED = (Phase.PREOP, Phase.RUN)  # TPDO counters run from the command Pre-Operational


class GovernorProgramme(Programme):
    """`tick` is the order of a main cycle; telegrams are handled when they arrive."""

    def __init__(
        self,
        unit: ControlUnit[Any],
        engine: Engine,
        operation: Operation,
        tables: Tables,
        noise: Noise,
    ) -> None:
        can = HeinzmannCan(unit.wiring, unit.store, partner=403, enable=4406)  # 7.1.1
        super().__init__(unit, can, OF_GOVERNOR)
        settings, cycle, scaling = unit.store, unit.cycle, tables.scaling
        self._engine, self._assignment = engine, tables.assignment
        parts = init_parts(settings, scaling, cycle)
        self.handshake = Handshake(unit.time, self.can.send, parts)
        self.inputs = Inputs(settings, cycle)
        self._noise = noise
        engine.run_to(self.time.now)
        governor = SpeedGovernor(
            engine, operation, cycle / 1_000_000, catches=operation.autostart or not unit.cold
        )
        self.control = EngineControl(engine, operation, self.inputs, scaling, governor)
        self.live |= self.control.measurements
        if noise.peak:
            self.live[SPEED] = self._pick_up
        self._tpdos = tpdos(settings, scaling, cycle)
        self._words = {
            tpdo.number: [(self._reader(n), scaling.of(n)) for n in tpdo.sources.values()]
            for tpdo in self._tpdos
        }
        self._constant = all(self._is_constant(n) for t in self._tpdos for n in t.sources.values())
        self._periods = [(tpdo.number, tpdo.period) for tpdo in self._tpdos]
        self.served = 0
        """Main cycles in which TPDOs may have been sent."""
        self._met = False  # the gateway was heard since the reset

    @property
    def state(self) -> GatewayState:
        """The governor's copy of the gateway's state."""
        return self.handshake.state

    def _pick_up(self) -> float:
        if not self._engine.turning:
            return self._engine.speed
        return max(0.0, self._engine.speed + self._noise.at(self.time.now))

    def tick(self) -> None:
        """One main cycle."""
        self.control.run_to(self.time.now)
        self._lead_gateway()
        self._evaluate_inputs()
        self.control.step(self.unit.memory.present)
        if self.handshake.phase is Phase.FAILED:
            self.errors.own |= CanopenError.INIT
        self.errors.follow(CanopenError.TIME_CTRL, self.inputs.tripped)
        self.evaluate()
        self._tell()
        self._serve_tpdos()
        self._cycles += 1

    def _lead_gateway(self) -> None:
        if self.link_failed:
            self.handshake.lost()
        else:
            self.handshake.step()

    def _evaluate_inputs(self) -> None:
        if self.state is GatewayState.OPERATIONAL:
            self.inputs.step()
        heartbeat = CanopenError.HEARTBEAT not in self.errors.word
        self.inputs.usable = self.state is GatewayState.OPERATIONAL and heartbeat

    @property
    def causes(self) -> int:
        """What is wrong at this moment: sensors and engine as well."""
        return super().causes | self.inputs.errors | self.control.causes

    def clear(self) -> None:
        """Clear all errors here; a failed initialisation gets three more attempts."""
        self.inputs.forgive()
        super().clear()
        self.handshake.cleared()

    def _tell(self) -> None:
        if self.alive_due:
            self.can.send(GovernorAlive(self.errors.own))
        if not self.can.silent:  # 7.2.1: to a silent partner the content is cut down
            present = self.unit.memory.present
            engine = self._assignment.engine_word(self.control.states(present))
            self.can.send(Binary(present, engine, self.errors.own))

    def _serve_tpdos(self) -> None:
        if self.handshake.phase not in SERVED:
            return
        self.served += 1
        for tpdo in self._tpdos:
            if self.served % tpdo.period == 0:
                self.can.send(TpdoData(tpdo.number, self.words(tpdo.number)))

    def _is_constant(self, number: int) -> bool:
        """Whether a parameter is as it was while nothing moves: no clock, no noise."""
        if number == SPEED and self._noise.peak:
            return False
        return self.unit.parameters[number].writable or number in self.live

    # At rest: see `settled`

    @property
    def is_steady(self) -> bool:
        """Whether the next main cycle does again what this one has done, as far as it knows."""
        led = self.handshake.phase is Phase.RUN and self._constant
        return led and self.can.is_steady and self.control.is_steady

    @property
    def patience(self) -> int:
        """Main cycles until something is missed; NEVER if nothing is waited for."""
        return self.inputs.patience if self.state is GatewayState.OPERATIONAL else NEVER

    def tpdos_after(self, cycle: int) -> tuple[int, list[int]]:
        """The next main cycle after one, as `served` counts them, that has TPDOs, and which.

        NEVER and none if there is no such cycle.
        """
        following = [(cycle + period - cycle % period, n) for n, period in self._periods]
        first = min(following)[0] if following else NEVER
        return first, [number for due, number in following if due == first]

    def tpdos_among(self, cycles: int) -> Iterator[int]:
        """The TPDOs of the next main cycles, each but once."""
        served = self.served + cycles
        yield from (number for number, period in self._periods if served % period < cycles)

    @property
    def told(self) -> dict[int, tuple[int, ...]]:
        """What every TPDO tells at this moment."""
        return {tpdo.number: self.words(tpdo.number) for tpdo in self._tpdos}

    def words(self, number: int) -> tuple[int, ...]:
        """What a TPDO tells at this moment."""
        return tuple(scale.internal(read()) for read, scale in self._words[number])

    def leap(self, cycles: int, last: int, heard: int) -> None:
        """Main cycles at rest; the last of them, and when the gateway was heard, in us."""
        if cycles:
            self._engine.reached = last
        self.can.hear(heard)
        self.control.leap(cycles)
        if self.state is GatewayState.OPERATIONAL:
            self.inputs.leap(cycles)
        self.served += cycles
        self._cycles += cycles

    def _reader(self, number: int) -> Callable[[], float]:
        if self.unit.parameters[number].writable:
            return partial(self.settings.effective, number)
        return self.live.get(number) or partial(measured, self.unit, number)

    def handle(self, telegram: Telegram) -> None:
        """Act on a telegram of the gateway."""
        match telegram.body:
            case GatewayAlive() as alive:
                self._follow_gateway(alive)
            case InitReady() as answer:
                self.handshake.ready(answer)
            case InitResult() as answer:
                self.handshake.judged(answer)
                self.served = 0
            case RpdoData(number, words):
                self.inputs.rpdos[number].take(words)
            case ClearErrors():
                self.clear()

    def _follow_gateway(self, alive: GatewayAlive) -> None:
        if not self._met and alive.epoch:  # it was commanded before this unit was reset
            self.errors.own |= CanopenError.DC_RESET
        self._met = True
        before = self.state
        self.handshake.heard(alive)
        if before is not self.state and self.state is GatewayState.OPERATIONAL:
            self.inputs.begin()
            self.errors.clear(self.causes)
        self.errors.partner = alive.errors


class Governor(ControlUnit[GovernorProgramme]):
    """The control unit, with the engine."""

    which, partner = Unit.GOVERNOR, Unit.GATEWAY
    inner_faults = (
        errors.PICK_UP,
        errors.OVERSPEED,
        *errors.SENSORS,
        *errors.OF_ENGINE,
        errors.INTERN,
    )

    def __init__(self, around: Surroundings, engine: Engine) -> None:
        super().__init__(around, microseconds(around.options.governor_cycle))
        self.desk = Desk(self, around.tables.catalogue)
        self.engine, self.operation = engine, Operation()
        engine.reached = self.time.now
        self._tables, options = around.tables, around.options
        self._noise = Noise(options.speed_noise, options.seed, self.cycle)

    def start(self) -> GovernorProgramme:
        """The programme, as it begins."""
        return GovernorProgramme(self, self.engine, self.operation, self._tables, self._noise)

    def power_off(self) -> None:
        """Lose what is not saved; actuator, starter and generator breaker fall off."""
        self.engine.run_to(self.time.now)
        self.engine.let_go()
        super().power_off()


HELD = attrgetter(
    *("handshake.state", "handshake.phase", "errors.own", "errors.partner"),
    *("_pulses", "inputs.usable"),
)
"""What the main cycles of a programme depend on."""
