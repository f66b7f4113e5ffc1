"""A device from the file that describes it: EDS, DCF, XDD or XDC.

Its entries are memory: what is written is read back, what is measured stays at its default until
somebody sets it. Every service that the file declares is there.
"""

import logging
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from canopen import ObjectDictionary
from canopen.objectdictionary.datatypes import FLOAT_TYPES, INTEGER8, SIGNED_TYPES

from canopen_twins.bus.identifiers import NODE_IDS
from canopen_twins.device.device import Device as AnyDevice
from canopen_twins.device.settings import NodeSettings, setting
from canopen_twins.devices.eds.network import BIT_TIMINGS, Network
from canopen_twins.errors import UserError
from canopen_twins.slave.dictionary import dictionary, read
from canopen_twins.slave.eds.reader import UNCONFIGURED, entries_of
from canopen_twins.slave.lss import LssSlave
from canopen_twins.slave.object import Address
from canopen_twins.slave.profile import Profile
from canopen_twins.slave.service import Service
from canopen_twins.slave.slave import Slave

log = logging.getLogger(__name__)

COMMANDS = (0x1003, 0x1010, 0x1011)  # what is written there is an order, not a value to keep
APPLICATION = 0x2000  # the first index that is no matter of communication
MEASURED_TYPES = {*SIGNED_TYPES, *FLOAT_TYPES} - {INTEGER8}
DELIVERED = 1  # node id of a file that says none


@dataclass(frozen=True)
class Settings(NodeSettings):
    """What a file leaves open."""

    modules: str = setting(
        "", "modules plugged into a modular coupler, by the numbers of its file: 1,1,2"
    )


class Device(AnyDevice):
    """Every file has a class of its own: see `device_of`."""

    settings = Settings()
    profile = Profile(block=True)
    version = 0
    """When its file was changed, so that a file that was edited is read anew."""

    @property
    def modules(self) -> Sequence[int] | None:
        """What is plugged in, none for what the file says.

        Raises:
            UserError: not numbers with commas between them.
        """
        try:
            return [int(word) for word in self.settings.modules.split(",")] or None
        except ValueError:
            if not self.settings.modules:
                return None
            told = f"setting 'modules' is numbers such as 1,1,2, not {self.settings.modules!r}"
            raise UserError(told) from None

    def make_model(self) -> None:
        """Where it is on the bus, as its memory has kept it."""
        self.network = Network(self.memory, int(self.settings.node_id))

    def check(self) -> None:
        """Raises `UserError` for a node id outside 1..127, and for modules that are no numbers."""
        if self.settings.node_id not in NODE_IDS:
            raise UserError(f"node id {self.settings.node_id} is not in 1..127")
        _ = self.modules

    @property
    def bit_rate(self) -> int | None:
        """What LSS has set; else any is right, as no file says one."""
        index = self.network.bit_timing
        return None if index is None else BIT_TIMINGS[index]

    @property
    def node_id(self) -> int:
        """That of the settings, or the one that LSS has set."""
        return self.network.node_id

    def reset_node(self) -> None:
        """NMT 81h: a node id that waits comes into force."""
        self.network.reset()

    def reset_communication(self) -> None:
        """NMT 82h: the same."""
        self.network.reset()

    def dictionary(self) -> ObjectDictionary:
        """That of the file, with the modules that are plugged in."""
        return dictionary(self.eds, self.node_id, self.modules, self.version)

    @property
    def measured(self) -> Collection[Address]:
        """What only the device changes and a PDO may carry, if it is no collection of bits."""
        return [
            (index, subindex)
            for index, item in self.dictionary().indices.items()
            if index >= APPLICATION
            for subindex, variable in entries_of(item).items()
            if variable.pdo_mappable
            and not variable.writable
            and variable.data_type in MEASURED_TYPES
        ]

    @property
    def stored(self) -> Collection[Address]:
        """Everything that a master may set and read back."""
        return [
            (index, subindex)
            for index, item in self.dictionary().indices.items()
            if index >= 0x1000 and index not in COMMANDS
            for subindex, variable in entries_of(item).items()
            if variable.writable and variable.readable
        ]

    def services(self, slave: Slave) -> Iterable[Service]:
        """LSS, if the file says so."""
        if self.dictionary().device_information.LSS_supported:
            yield LssSlave(slave, self.network)


def device_of(path: Path) -> type[Device]:
    """The device that a file describes; what is unusual in it is logged once.

    Raises:
        UserError: there is no such file, or it describes no device.
    """
    try:
        changed = path.stat().st_mtime_ns
    except OSError as failure:
        raise UserError(f"{path}: {failure.strerror}") from failure
    return _device_of(path.resolve(), path.name, changed)


@cache
def _device_of(path: Path, name: str, version: int) -> type[Device]:
    file = read(str(path))
    for remark in file.remarks:
        log.warning("%s", remark.told(name))
    told = file.dictionary.device_information
    words = " ".join(filter(None, (told.vendor_name, told.product_name)))
    node_id = file.node_id if file.node_id not in {None, UNCONFIGURED} else DELIVERED
    return type(
        path.stem,
        (Device,),
        {
            "__module__": __name__,
            "__doc__": f"The device of {name}.",
            "eds": str(path),
            "version": version,
            "title": f"{words} ({name})" if words else name,
            "settings": Settings(node_id=node_id),
        },
    )
