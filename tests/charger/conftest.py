import pytest
import yaml
from charger_bus import release

from canopen_twins import Bench
from canopen_twins.devices.charger.messages import read_catalogue
from canopen_twins.devices.charger.model.charger import Charger
from canopen_twins.devices.charger.model.parameters import Parameter
from canopen_twins.devices.charger.model.release import ReleaseSource
from canopen_twins.devices.charger.model.types import PCSC, Build, Variant
from canopen_twins.devices.charger.object_table import factory
from canopen_twins.files.shipped import od_file


@pytest.fixture(scope="session")
def catalogue_data():
    with od_file("charger_messages.yaml") as path:
        return yaml.safe_load(path.read_text("ascii"))


@pytest.fixture(scope="session")
def catalogue():
    with od_file("charger_messages.yaml") as path:
        return read_catalogue(path)


@pytest.fixture
def make(catalogue):
    """A charger that CANopen may release; parameters by their names in lower case."""

    def make(kind=PCSC, variant=Variant.BASE, *, superset=False, sparks=None, **parameters):
        given = {Parameter[name.upper()]: value for name, value in parameters.items()}
        values = {**factory(kind), Parameter.RELEASE_MODE: ReleaseSource.CANOPEN.value, **given}
        return Charger(Build(kind, variant, superset), values, catalogue, sparks)

    return make


@pytest.fixture
def charger(make):
    return make()


@pytest.fixture
def switch_on():
    """Release a charger and let its ramp end."""

    def switch_on(charger, seconds=1.0):
        charger.grant(ReleaseSource.CANOPEN)
        charger.step(seconds)

    return switch_on


@pytest.fixture
def running(make, switch_on):
    """A PCSC at 20 kV on its own bar."""
    charger = make(voltage_setpoint=20000)
    switch_on(charger)
    return charger


@pytest.fixture
def active():
    """The keys of the active messages of a charger, in the order in which they came."""

    def active(charger):
        return [(message.severity.name, message.key) for message in charger.messages.active]

    return active


@pytest.fixture
def bench():
    """A PCSC with power on, node id 99; its boot-up message is out."""
    return Bench("charger")


@pytest.fixture
def quiet(bench):
    """The same without a heartbeat."""
    bench.sdo[0x1017].raw = 0
    return bench


@pytest.fixture
def on(quiet):
    """The same at 20 kV on its own bar, in Pre-operational."""
    release(quiet)
    return quiet
