"""One twin on a bench, as a test sees it: its supply, its faults, and a master's view of it."""

from typing import Any

import canopen

from canopen_twins.bus.segment import Segment
from canopen_twins.device.device import Device
from canopen_twins.device.node import Node
from canopen_twins.errors import UserError
from canopen_twins.faults import connect


class Twin:
    """A device by its name on a segment, and the canopen network of the master beside it."""

    def __init__(
        self, name: str, device: Device, segment: Segment[Node], master: canopen.Network
    ) -> None:
        self.name = name
        self.node: Node = connect(segment, device, name)
        self._segment = segment
        self._master = master

    @property
    def device(self) -> Any:
        """The device itself as it is at this moment, to look at its model or to act on it."""
        self._see_to_it()
        self._segment.deliver()
        self._segment.touch(self._see_to_it)
        return self.node.device

    def _see_to_it(self) -> None:
        with self.node.acting():
            pass

    @property
    def remote(self) -> canopen.RemoteNode:
        """The master's view of the node, with the dictionary of its EDS."""
        node_id = self.node.node_id
        if node_id not in self._master:
            added = self._master.add_node(node_id, self.node.device.dictionary())
            added.sdo.RESPONSE_TIMEOUT = 0.0  # the answer is there already, or never comes
        remote = self._master[node_id]
        assert isinstance(remote, canopen.RemoteNode)
        return remote

    @property
    def sdo(self) -> Any:
        """SDO access by a real client: `sdo["Run command"].raw = 1`."""
        return self.remote.sdo

    def inject(self, name: str, **parameters: Any) -> None:
        """Let something go wrong.

        Raises:
            UserError: no such fault or parameter.
        """
        with self.node.acting():
            self.node.faults.inject(name, **parameters)
        self._segment.deliver()

    def clear(self, name: str | None = None) -> None:
        """Take one fault away, or all of them.

        Raises:
            UserError: no such fault.
        """
        with self.node.acting():
            self.node.faults.clear(name)
        self._segment.deliver()

    def set(self, **settings: object) -> None:
        """Change live settings, such as the load.

        Raises:
            UserError: no such setting, a wrong value, or one taken over at power-on only.
        """
        with self.node.acting() as device:
            device.set(**settings)
        self._segment.deliver()

    def power_off(self) -> None:
        """Switch the supply off."""
        self.node.power_off()

    def power_on(self, **settings: object) -> None:
        """Switch the supply on, with other settings if any are given.

        Raises:
            UserError: no such setting, a wrong value, or the power is on already.
        """
        if settings and self.node.powered:
            raise UserError(f"the power is on: switch it off to change {', '.join(settings)}")
        if settings:
            self.node.device.configure(**settings)
        self.node.power_on()
        self._segment.deliver()
