"""A twin of another process, by its control port: needs nothing but the standard library."""

import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from http.client import HTTPConnection, HTTPException, HTTPResponse
from typing import Any
from urllib.parse import quote, urlencode

from canopen_twins.bench.twin import Twin
from canopen_twins.bus.hub.protocol import HubAddress
from canopen_twins.errors import UserError

PATIENCE = 15.0  # seconds for an answer
LARGEST = 1 << 24  # bytes of an answer
HTTP = "http://"


class RemotePort:
    """Says what the twins of another process are to do, each time by a connection of its own.

    Raises:
        UserError: the address is none.
    """

    def __init__(self, address: str, token: str = "") -> None:
        self._address = HubAddress.parse(address.removeprefix(HTTP).rstrip("/"), port=0)
        if not self._address.port:
            raise UserError(f"{address} has no port: write HOST:PORT, as in the ready line")
        self._headers = {"Content-Type": "application/json"}
        if token:
            self._headers["Authorization"] = f"Bearer {token}"

    def __str__(self) -> str:
        return f"{HTTP}{self._address}"

    def call(self, method: str, path: str, body: Any = None) -> Any:
        """What is answered.

        Raises:
            UserError: nobody is there, or it is refused.
            RuntimeError: there is a bug in the other process.
        """
        with self._answer(method, path, body) as answer:
            try:
                return json.loads(answer.read(LARGEST))
            except json.JSONDecodeError:
                raise UserError(f"no twin answers at {self}: this is no JSON") from None

    def events(self, path: str = "/events") -> Iterator[Mapping[str, Any]]:
        """What happens, as it happens, until the twins end; raises as `call` does."""
        with self._answer("GET", path, None) as answer:
            for line in answer:
                if line.startswith(b"data: "):
                    yield json.loads(line[6:])

    @contextmanager
    def _answer(self, method: str, path: str, body: Any) -> Iterator[HTTPResponse]:
        host, port = self._address
        connection = HTTPConnection(host, port, timeout=PATIENCE)
        sent = None if body is None else json.dumps(body)
        try:
            connection.request(method, path, sent, self._headers)
            answer = connection.getresponse()
            if answer.status >= 400:
                raise _refusal(answer)
            yield answer
        except (OSError, HTTPException) as failure:
            raise UserError(f"no twin answers at {self}: {failure}") from failure
        finally:
            connection.close()


def _refusal(answer: HTTPResponse) -> Exception:
    content = answer.read(LARGEST)
    try:
        detail = json.loads(content)["detail"]
    except (ValueError, TypeError, KeyError):
        detail = content.decode("utf-8", "replace").strip()
    if answer.status == 500:
        return RuntimeError(f"a bug in the process of the twin, which tells more: {detail}")
    return UserError(str(detail))


class RemoteTwin(Twin):
    """A node behind a control port. Values of bytes are told in hex; `name` is that of the node."""

    def __init__(self, port: RemotePort, name: str) -> None:
        self.port = port
        self.name = name
        self._path = f"/nodes/{quote(name, safe='')}"

    def order(self, word: str, *arguments: Any) -> None:
        """By HTTP; it is over when this returns."""
        self.moment_of(word, *arguments)

    def moment_of(self, word: str, *arguments: Any) -> int:
        """The same, with the moment at which it took effect, in microseconds of its bus."""
        method, path, body = _request(word, *arguments)
        moment: int = self.port.call(method, f"{self._path}/{path}", body)["moment"]
        return moment

    @property
    def state_now(self) -> Mapping[str, Any]:
        """All that `GET /nodes/NAME` tells."""
        told: Mapping[str, Any] = self.port.call("GET", self._path)
        return told

    @property
    def faults(self) -> Mapping[str, Any]:
        """What can go wrong, and what has: `GET /nodes/NAME/faults`."""
        told: Mapping[str, Any] = self.port.call("GET", f"{self._path}/faults")
        return told

    def ask(self, word: str, *arguments: Any) -> Any:
        """By HTTP, too."""
        if word == "values":
            query = urlencode([("name", name) for name in arguments[0]])
            return self.port.call("GET", f"{self._path}/values?{query}")
        if word == "settings":
            told = self.port.call("GET", f"{self._path}/settings")
            return {each["name"]: each["value"] for each in told}
        state = self.state_now
        if word == "active_faults":
            return {each["name"]: each["parameters"] for each in state["faults"]}
        return state[word]


def _request(word: str, *arguments: Any) -> tuple[str, str, Any]:
    """Method, path and body of one of `bench.twin.ORDERS`."""
    match word, arguments:
        case "inject", (name, parameters):
            return "POST", f"faults/{quote(name, safe='')}", parameters
        case "clear", (None,):
            return "DELETE", "faults", None
        case "clear", (name,):
            return "DELETE", f"faults/{quote(name, safe='')}", None
        case "set", (settings,):
            return "PATCH", "settings", settings
        case "power_on", (settings,):
            return "PUT", "power", {"on": True, "settings": settings}
        case "power_off", ():
            return "PUT", "power", {"on": False}
    raise ValueError(f"no order {word!r}")


def connect(address: str, node: str | None = None, token: str = "") -> Twin:
    """A twin that runs in another process with `run --control`.

    Args:
        address: As the ready line tells it: http://127.0.0.1:8123, or without http://.
        node: Its name or its node id; may be left out if there is only one.
        token: That of `--control-token`.

    Raises:
        UserError: no twin answers there, there is no such node, or there are several.
    """
    return twin_of(RemotePort(address, token), node)


def twin_of(port: RemotePort, node: str | None) -> RemoteTwin:
    """A node of a port, the only one if none is named; raises as `connect` does."""
    if node is not None:
        return RemoteTwin(port, port.call("GET", f"/nodes/{quote(str(node), safe='')}")["name"])
    names = [each["name"] for each in port.call("GET", "/nodes")]
    if len(names) != 1:
        raise UserError(f"there are {', '.join(names)}: say which node")
    return RemoteTwin(port, names[0])
