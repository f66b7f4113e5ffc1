"""The two machines: control units with what is wired to them, and the programmes they run."""

from dataclasses import dataclass

from canopen_twins.devices.gateway.model import errors
from canopen_twins.devices.gateway.model.assignment import Assignment
from canopen_twins.devices.gateway.model.canopen_side import Plug
from canopen_twins.devices.gateway.model.desk import Desk
from canopen_twins.devices.gateway.model.engine import Engine
from canopen_twins.devices.gateway.model.engine_control import Operation
from canopen_twins.devices.gateway.model.gateway import GatewayProgramme
from canopen_twins.devices.gateway.model.governor import GovernorProgramme
from canopen_twins.devices.gateway.model.options import Options
from canopen_twins.devices.gateway.model.parameters import Catalogue, Unit
from canopen_twins.devices.gateway.model.scaling import Scaling
from canopen_twins.devices.gateway.model.timing import microseconds
from canopen_twins.devices.gateway.model.unit import ControlUnit, Surroundings


@dataclass(frozen=True)
class Tables:
    """What the manuals say in tables, and what is assumed in their place."""

    catalogue: Catalogue
    scaling: Scaling
    assignment: Assignment


class Governor(ControlUnit[GovernorProgramme]):
    """The control unit of type DC, with the engine."""

    which, partner = Unit.GOVERNOR, Unit.GATEWAY
    inner_faults = (errors.PICK_UP, errors.OVERSPEED, *errors.SENSORS, errors.INTERN)

    def __init__(self, around: Surroundings, tables: Tables, options: Options) -> None:
        super().__init__(around, microseconds(options.governor_cycle), options)
        self.desk = Desk(self, tables.catalogue)
        self.engine = Engine(around.time)
        self.operation = Operation()
        self._tables = tables

    def start(self) -> GovernorProgramme:
        """The programme, as it begins."""
        tables = self._tables
        return GovernorProgramme(
            self, self.engine, self.operation, tables.scaling, tables.assignment
        )

    def power_off(self) -> None:
        """Lose what is not saved; actuator, starter and load fall off."""
        if self.programme is not None:
            self.programme.end()
        super().power_off()


class Gateway(ControlUnit[GatewayProgramme]):
    """The control unit of type CM, with the CANopen plug."""

    which, partner = Unit.GATEWAY, Unit.GOVERNOR
    inner_faults = errors.FATAL

    def __init__(self, around: Surroundings, tables: Tables, options: Options) -> None:
        super().__init__(around, microseconds(options.gateway_cycle), options)
        self.desk = Desk(self, tables.catalogue)
        self.plug = Plug()
        self._tables, self._options = tables, options

    def start(self) -> GatewayProgramme:
        """The programme, as it begins."""
        return GatewayProgramme(self, self.plug, self._tables.assignment, self._options)
