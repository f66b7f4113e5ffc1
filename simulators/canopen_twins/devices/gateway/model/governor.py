"""Programme of the governor: governs the engine, initialises the gateway, serves its PDOs."""

from collections.abc import Callable
from functools import partial
from typing import Any

from canopen_twins.devices.gateway.model import configuration, errors
from canopen_twins.devices.gateway.model.assignment import Assignment
from canopen_twins.devices.gateway.model.canopen_errors import OF_GOVERNOR, CanopenError
from canopen_twins.devices.gateway.model.engine import Engine
from canopen_twins.devices.gateway.model.engine_control import EngineControl, Operation
from canopen_twins.devices.gateway.model.handshake import Handshake, Phase
from canopen_twins.devices.gateway.model.heinzmann_can import Numbers
from canopen_twins.devices.gateway.model.inputs import Inputs
from canopen_twins.devices.gateway.model.measurements import measured
from canopen_twins.devices.gateway.model.programme import Programme
from canopen_twins.devices.gateway.model.scaling import Scaling
from canopen_twins.devices.gateway.model.state import State
from canopen_twins.devices.gateway.model.telegrams import (
    Binary,
    ClearErrors,
    GatewayAlive,
    GovernorAlive,
    InitReady,
    InitResult,
    RpdoData,
    Telegram,
    TpdoData,
)
from canopen_twins.devices.gateway.model.unit import ControlUnit

NUMBERS = Numbers(partner=403, enable=4406)  # 7.1.1
OVERSPEED = errors.bit(errors.OVERSPEED)
SERVED = (Phase.PREOP, Phase.RUN)  # TPDO counters run from the command Pre-Operational


class GovernorProgramme(Programme):
    """`tick` is the order of a main cycle; telegrams are handled when they arrive."""

    def __init__(
        self,
        unit: ControlUnit[Any],
        engine: Engine,
        operation: Operation,
        scaling: Scaling,
        assignment: Assignment,
    ) -> None:
        super().__init__(unit, NUMBERS, OF_GOVERNOR)
        settings, cycle = unit.store, unit.cycle
        self._engine, self._assignment = engine, assignment
        parts = configuration.init_parts(settings, scaling, cycle)
        self.handshake = Handshake(unit.time, self.can.send, parts)
        self.inputs = Inputs(
            configuration.sensors(settings),
            configuration.switch_functions(settings),
            configuration.monitoring(settings, cycle),
        )
        self.control = EngineControl(engine, operation, self.inputs, scaling, cycle / 1_000_000)
        self.live |= self.control.measurements
        self._tpdos = configuration.tpdos(settings, scaling, cycle)
        self._words = {
            tpdo.number: [(self._reader(n), scaling.count(n)) for n in tpdo.sources.values()]
            for tpdo in self._tpdos
        }
        self._served = 0  # main cycles
        self._met = False  # the gateway was heard since the reset

    @property
    def state(self) -> State:
        """The governor's copy of the gateway's state."""
        return self.handshake.state

    @property
    def tripped(self) -> bool:
        """Whether overspeed has stopped the engine, until the errors are cleared."""
        return self.unit.memory.has(errors.OVERSPEED)

    def end(self) -> None:
        """The unit is reset or switched off."""
        self._engine.run_to(self.time.now)
        self.control.end()

    def tick(self) -> None:
        """One main cycle."""
        self._engine.run_to(self.time.now)
        self._lead_gateway()
        self._evaluate_inputs()
        self.control.step(tripped=self.tripped)
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
        if self.state is State.OPERATIONAL:
            self.inputs.step()
        heartbeat = CanopenError.HEARTBEAT not in self.errors.word
        self.inputs.usable = self.state is State.OPERATIONAL and heartbeat

    @property
    def causes(self) -> int:
        """What is wrong at this moment: sensors and overspeed as well."""
        causes = super().causes | self.inputs.errors
        return causes | OVERSPEED if self.control.overspeed else causes

    def clear(self) -> None:
        """Clear all errors here; a failed initialisation gets three more attempts."""
        self.inputs.forgive()
        super().clear()
        self.handshake.cleared()

    def _tell(self) -> None:
        if self.alive_due:
            self.can.send(GovernorAlive(self.errors.own))
        if not self.can.silent:  # 7.2.1: to a silent partner the content is cut down
            engine = self._assignment.engine_word(self.control.states(tripped=self.tripped))
            self.can.send(Binary(self.unit.memory.present, engine, self.errors.own))

    def _serve_tpdos(self) -> None:
        if self.handshake.phase not in SERVED:
            return
        self._served += 1
        for tpdo in self._tpdos:
            if self._served % tpdo.period == 0:
                words = [count.of(read()) for read, count in self._words[tpdo.number]]
                self.can.send(TpdoData(tpdo.number, tuple(words)))

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
                self._served = 0
            case RpdoData(number, words):
                self.inputs.rpdos[number].receive(words)
            case ClearErrors():
                self.clear()

    def _follow_gateway(self, alive: GatewayAlive) -> None:
        if not self._met and not alive.fresh:
            self.errors.own |= CanopenError.DC_RESET
        self._met = True
        before = self.state
        self.handshake.heard(alive)
        if before is not self.state and self.state is State.OPERATIONAL:
            self.inputs.begin()
            self.errors.clear(self.causes)
        self.errors.partner = alive.errors
