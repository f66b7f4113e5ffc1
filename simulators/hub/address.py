"""Where a hub is: HOST:PORT."""

import re
from ipaddress import ip_address
from typing import NamedTuple

from simulators.errors import UserError

LOOPBACK, PORT = "127.0.0.1", 29536  # the port of socketcand


class Address(NamedTuple):
    """A host by its name or number, and a TCP port."""

    host: str = LOOPBACK
    port: int = PORT

    @classmethod
    def parse(cls, text: str) -> "Address":
        """Read HOST:PORT, where either may be left out; numbers of IPv6 stand in brackets.

        Raises:
            UserError: the text is no address.
        """
        match = re.fullmatch(
            r"(?P<host>\[[0-9A-Fa-f:.]+\]|[^:\[\]]*)(:(?P<port>[0-9]{1,5}))?", text
        )
        if not match or int(match["port"] or 0) > 0xFFFF:
            raise UserError(f"{text!r} is no address: write HOST:PORT, such as {cls()}")
        port = PORT if match["port"] is None else int(match["port"])
        return cls(match["host"].strip("[]") or LOOPBACK, port)

    @property
    def is_loopback(self) -> bool:
        """Whether nobody outside this machine, or this container, is reached there."""
        try:
            return ip_address(self.host).is_loopback
        except ValueError:
            return self.host == "localhost"

    def __str__(self) -> str:
        return f"[{self.host}]:{self.port}" if ":" in self.host else f"{self.host}:{self.port}"
