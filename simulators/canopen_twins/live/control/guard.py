"""Who may use the control port, and for how long: any page in a browser reaches it, too."""

import hmac
from asyncio import BaseTransport, TimerHandle, Transport, get_running_loop
from collections.abc import Callable, Mapping
from urllib.parse import parse_qs

import h11
from starlette.responses import JSONResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send
from uvicorn.protocols.http.h11_impl import H11Protocol

LARGEST_BODY = 1 << 18  # bytes
PATIENCE = 10.0  # seconds for a client to say what it wants, and to take what it is told
SPEAKING = (h11.IDLE, h11.SEND_BODY)  # states of a client that has not said all of its request
SAFE = ("GET", "HEAD")
LOCAL = ("127.0.0.1", "localhost", "[::1]")


class Deadline:
    """Acts if it does not end in time."""

    def __init__(self, act: Callable[[], None]) -> None:
        self._act = act
        self._timer: TimerHandle | None = None

    def begin(self) -> None:
        """From now on, unless it has begun already."""
        if self._timer is None:
            self._timer = get_running_loop().call_later(PATIENCE, self._act)

    def end(self) -> None:
        """It was in time."""
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None


class HurriedProtocol(H11Protocol):
    """HTTP with clients that have their time: uvicorn waits for ever for the end of a request.

    There are so many connections and no more: who says nothing, goes on for ever, or reads no
    answer would keep one from others.
    """

    def connection_made(self, transport: BaseTransport) -> None:
        """Its first request is waited for."""
        assert isinstance(transport, Transport)
        super().connection_made(transport)
        self._to_speak, self._to_read = Deadline(transport.abort), Deadline(transport.abort)
        self._to_speak.begin()

    def data_received(self, data: bytes) -> None:
        """From the first byte of a request to its last the time is one."""
        super().data_received(data)
        if self.conn.their_state in SPEAKING:
            self._to_speak.begin()
        else:
            self._to_speak.end()

    def pause_writing(self) -> None:
        """It does not read."""
        super().pause_writing()
        self._to_read.begin()

    def resume_writing(self) -> None:
        """It has read."""
        super().resume_writing()
        self._to_read.end()

    def connection_lost(self, exc: Exception | None) -> None:
        """It has gone."""
        super().connection_lost(exc)
        self._to_speak.end()
        self._to_read.end()


class Guard:
    """Stands before the port and lets through what its user has asked for.

    Without a token a request has to call this machine by a name that no page can own, which is what
    DNS rebinding does; with one every request has to bring it, as `Authorization: Bearer TOKEN` or
    as `?token=`. What changes something comes as JSON, which no page of another origin may send.
    """

    def __init__(self, app: ASGIApp, token: str = "") -> None:
        self._app = app
        self._token = token

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer with 401, 403, 413 or 415, or pass on."""
        if scope["type"] != "http":
            return
        headers = {
            key.decode("latin-1"): value.decode("latin-1") for key, value in scope["headers"]
        }
        if refusal := self._refusal(scope, headers):
            status, detail = refusal
            await JSONResponse({"detail": detail}, status)(scope, receive, send)
            return
        if scope["method"] in SAFE:
            await self._app(scope, receive, send)
            return
        try:
            body = await _read(receive)
        except ConnectionError:  # half an order is none
            return
        if body is None:
            detail = f"the body is larger than {LARGEST_BODY // 1024} KiB"
            await JSONResponse({"detail": detail}, 413)(scope, receive, send)
            return
        await self._app(scope, _once(body, receive), send)

    def _refusal(self, scope: Scope, headers: Mapping[str, str]) -> tuple[int, str] | None:
        host = headers.get("host", "")
        if self._token:
            if not hmac.compare_digest(_token(scope, headers), self._token.encode()):
                return 401, "say the token of --control-token: Authorization: Bearer TOKEN"
        elif host.rpartition(":")[0] not in LOCAL and host not in LOCAL:
            return 403, f"this port is called 127.0.0.1 or localhost, not {host!r}"
        origin = headers.get("origin")
        if origin is not None and origin.partition("://")[2] != host:
            return 403, f"a page of {origin} has no business here"
        kind = headers.get("content-type", "").partition(";")[0].strip().lower()
        if scope["method"] not in SAFE and kind != "application/json":
            return 415, "say Content-Type: application/json"
        return None


def _token(scope: Scope, headers: Mapping[str, str]) -> bytes:
    kind, _, token = headers.get("authorization", "").partition(" ")
    if kind.lower() != "bearer":
        query = parse_qs(scope["query_string"].decode("latin-1"))
        token = query.get("token", [""])[0]
    return token.strip().encode()


async def _read(receive: Receive) -> bytes | None:
    """The whole body; none if it is too large.

    Raises:
        ConnectionError: the client has gone before its end.
    """
    body = bytearray()
    while True:
        message = await receive()
        if message["type"] == "http.disconnect":
            raise ConnectionError
        body += message.get("body", b"")
        if len(body) > LARGEST_BODY:
            return None
        if not message.get("more_body", False):
            return bytes(body)


def _once(body: bytes, receive: Receive) -> Receive:
    """Gives a body that has been read, then whatever else comes."""
    left = [body]

    async def again() -> Message:
        if left:
            return {"type": "http.request", "body": left.pop(), "more_body": False}
        return await receive()

    return again
