"""A device from the file that describes it: EDS, DCF, XDD or XDC.

Its entries are memory: what is written is read back, what is measured stays at its default until
somebody sets it. Every service that the file declares is there.
"""

import logging
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from canopen import ObjectDictionary
from canopen.objectdictionary.datatypes import DOMAIN, FLOAT_TYPES, INTEGER8, SIGNED_TYPES

from canopen_twins.bus.identifiers import NODE_IDS, UNCONFIGURED
from canopen_twins.device.settings import NodeSettings, setting
from canopen_twins.devices.eds.network import BIT_TIMINGS, Network
from canopen_twins.devices.eds.settable import Settable
from canopen_twins.errors import UserError
from canopen_twins.files.sections import Remark
from canopen_twins.slave.dictionary import dictionary, read
from canopen_twins.slave.emcy import Emcy
from canopen_twins.slave.lss import LssSlave
from canopen_twins.slave.object import Address, entries_of
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


class Device(Settable):
    """Every file has a class of its own: see `device_of`."""

    settings = Settings()
    profile = Profile(block=True, longest_transfer=1 << 20, tells_bus_errors=True)
    remarks: tuple[Remark, ...] = ()
    """What is wrong or unusual in the file."""
    has_lss = False
    """Whether its file says so."""
    version = 0
    """When its file was changed, so that a file that was edited is read anew."""

    @property
    def modules(self) -> tuple[int, ...] | None:
        """What is plugged in, none for what the file says.

        Raises:
            UserError: not numbers with commas between them.
        """
        try:
            return tuple(int(word) for word in self.settings.modules.split(","))
        except ValueError:
            if not self.settings.modules:
                return None
            told = f"setting 'modules' is numbers such as 1,1,2, not {self.settings.modules!r}"
            raise UserError(told) from None

    def make_model(self) -> None:
        """Where it is on the bus, as its memory has kept it."""
        self.network = Network(self.memory, int(self.settings.node_id))
        self.heard: dict[int, Emcy] = {}

    def check(self) -> None:
        """Look at node id and modules.

        Raises:
            UserError: a node id outside 1..127, but for 255 where LSS can set one; modules that are
                no numbers.
        """
        node_id = self.settings.node_id
        if node_id not in NODE_IDS and not (node_id == UNCONFIGURED and self.has_lss):
            raise UserError(f"node id {node_id} is not in 1..127")
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
        return _settable(self.eds, self.modules, self.version)

    def on_emcy(self, node_id: int, emcy: Emcy) -> None:
        """The last one of each node is shown."""
        self.heard[node_id] = emcy

    @property
    def report(self) -> Mapping[str, object]:
        """What it has heard of others."""
        return {f"EMCY of node {node_id}": f"{e.code:04X}h" for node_id, e in self.heard.items()}

    def services(self, slave: Slave) -> Iterable[Service]:
        """LSS, if the file says so."""
        yield from super().services(slave)
        if self.has_lss:
            yield LssSlave(slave, self.network)


@cache
def _settable(eds: str, modules: tuple[int, ...] | None, version: int) -> Collection[Address]:
    return [
        (index, subindex)
        for index, item in dictionary(eds, 0, modules, version).indices.items()
        if index >= 0x1000 and index not in COMMANDS
        for subindex, variable in entries_of(item).items()
        if variable.writable and variable.readable and variable.data_type != DOMAIN
    ]


def device_of(path: Path) -> type[Device]:
    """The device that a file describes; what is unusual in it is logged once.

    Raises:
        UserError: there is no such file, or it describes no device.
    """
    kind = described(path)
    for remark in kind.remarks:
        _warn(kind.files[0], remark)
    return kind


@cache
def _warn(path: Path, remark: Remark) -> None:
    log.warning("%s", remark.told(path.name))


def described(path: Path) -> type[Device]:
    """The same for whoever tells its remarks in another way."""
    try:
        changed = path.stat().st_mtime_ns
    except OSError as failure:
        raise UserError(f"{path}: {failure.strerror}") from failure
    return _described(path.resolve(), path.name, changed)


@cache
def _described(path: Path, name: str, version: int) -> type[Device]:
    file = read(str(path), None, version)
    told = file.dictionary.device_information
    words = " ".join(filter(None, (told.vendor_name, told.product_name)))
    node_id = file.node_id or DELIVERED
    if node_id == UNCONFIGURED and not told.LSS_supported:  # nobody could ever set one
        node_id = DELIVERED
    return type(
        path.stem,
        (Device,),
        {
            "__module__": __name__,
            "__doc__": f"The device of {name}.",
            "eds": str(path),
            "version": version,
            "title": f"{words} ({name})" if words else name,
            "bit_rate": file.dictionary.bitrate,
            "files": (path, *file.files),
            "has_lss": bool(told.LSS_supported),
            "remarks": tuple(file.remarks),
            "settings": Settings(node_id=node_id),
        },
    )
