"""How long a plant can be left alone: whether it moves, and when heat or I2t will act."""

from simulators.devices.topcon.model.heat import HOT, WARM, derated_at
from simulators.devices.topcon.model.plant import Plant

TOUCH = 1.001  # the derated maximum bends the output from this much above the current on
EVEN = 1e-4  # K: so near its end, the temperature moves the output by 0.01 parts at most
SLOW = 1e-3  # of full scale a step: heat moves the output no faster
CREEP = 0.01  # s in one go while it does


def settled(plant: Plant) -> bool:
    """Whether voltage and current will stay as they are."""
    return plant.circuit.settled and _ramped(plant) and not _heat_bends_output(plant)


def ahead(plant: Plant) -> float:
    """Seconds that can pass in one go: 0 while something moves, inf if nothing ever will."""
    if settled(plant):
        return _quiet(plant)
    creeps = plant.circuit.drift <= SLOW and _ramped(plant) and _heat_bends_output(plant)
    return CREEP if creeps else 0.0


def _quiet(plant: Plant) -> float:
    """Seconds until a settled plant reaches its next level of heat or I2t."""
    end = plant.heat.end(plant.loss, plant.ambient)
    bend = derated_at(TOUCH * plant.circuit.current / plant.unit.maximum_current)
    current, limit = plant.circuit.current, plant.unit.i2t_limit
    return min(
        *(plant.heat.time_to(level, end) for level in (WARM, bend, HOT)),
        *(plant.store.time_to(level, current) for level in (limit / 2, limit)),
    )


def _ramped(plant: Plant) -> bool:
    reached = plant.ramps.reached(plant.voltage_reference, plant.current_reference)
    return reached or not plant.running


def _heat_bends_output(plant: Plant) -> bool:
    if plant.heat.temperature < WARM or not plant.running:
        return False
    end = plant.heat.end(plant.loss, plant.ambient)
    touches = plant.derated_maximum <= TOUCH * plant.circuit.current
    return touches and abs(end - plant.heat.temperature) > EVEN
