"""The control port in HTTP: every path, what it takes, and what it answers."""

import asyncio
import json
from collections.abc import Callable
from importlib.metadata import version
from typing import Annotated, Any, TypeVar

from fastapi import Body, FastAPI, HTTPException, Request
from fastapi.exceptions import RequestValidationError
from pydantic import BaseModel, Field
from starlette.responses import JSONResponse, Response

from canopen_twins.bench.twin import carry_out
from canopen_twins.bus.segment import Segment
from canopen_twins.device.node import Node
from canopen_twins.errors import UserError, unknown
from canopen_twins.live.control.schema import Done, NodeName, NodeState, Refusal, Scalar
from canopen_twins.live.control.view import node_name, node_state
from canopen_twins.live.orders import Orders

PATIENCE = 10.0  # seconds for the twins to do what they are asked
DESCRIPTION = "Hands on the running twins of a bus: what is done takes effect between two frames."
REFUSALS: dict[int | str, dict[str, Any]] = {
    404: {"model": Refusal, "description": "No such node or fault"},
    422: {"model": Refusal, "description": "A wrong name or value, in one line"},
    503: {"model": Refusal, "description": "The twins do not answer"},
}

Answer = TypeVar("Answer")
Given = Annotated[dict[str, Scalar], Body(default_factory=dict)]


class Power(BaseModel, extra="forbid", strict=True):
    """The supply of a node."""

    on: bool
    settings: dict[str, Scalar] = Field(default_factory=dict)
    """Other settings to be switched on with."""


class Json(Response):
    """What `schema` says, as it is: nothing walks through it a second time."""

    media_type = "application/json"

    def render(self, content: Any) -> bytes:
        """Dataclasses are objects."""
        return json.dumps(content, default=vars).encode()


class Desk:
    """Asks the thread of the twins, and waits without holding the others up."""

    def __init__(self, segment: Segment[Node], orders: Orders) -> None:
        self.segment = segment
        self.orders = orders
        self.nodes = {node.wire.name: node for node in segment.nodes}

    def node(self, name: str) -> Node:
        """A node by its name or its node id; raises `HTTPException` with 404 if there is none."""
        if name in self.nodes:
            return self.nodes[name]
        for node in self.nodes.values():
            if name == str(node.node_id):
                return node
        raise _not_found("node", name, self.nodes)

    async def ask(self, action: Callable[[], Answer]) -> Answer:
        """What comes of an action.

        Raises:
            UserError: as the action does.
            HTTPException: 503 if the twins have stopped.
        """
        waiting = asyncio.wrap_future(self.orders.put(action))
        try:
            return await asyncio.wait_for(waiting, PATIENCE)
        except (TimeoutError, asyncio.CancelledError):
            raise HTTPException(503, "the twins do not answer") from None

    async def order(self, node: Node, word: str, *arguments: Any) -> Json:
        """One of `ORDERS`, with the moment at which it took effect."""
        return Json(Done(await self.ask(lambda: carry_out(self.segment, node, word, *arguments))))

    async def fault(self, node: str, fault: str) -> Node:
        """The node, if it has a fault of this name."""
        found = self.node(node)
        known = await self.ask(lambda: found.faults.known)
        if fault not in known:
            raise _not_found("fault", fault, known)
        return found


def _not_found(what: str, name: str, known: Any) -> HTTPException:
    return HTTPException(404, str(unknown(what, name, known)))


def make_app(desk: Desk) -> FastAPI:
    """The port of some twins."""
    app = FastAPI(
        title="canopen-twins",
        version=version("canopen-twins"),
        description=DESCRIPTION,
        docs_url=None,
        redoc_url=None,
        responses=REFUSALS,
    )
    _add_errors(app)
    _add_orders(app, desk)
    _add_nodes(app, desk)  # its paths would take those of the others for names
    return app


def _add_errors(app: FastAPI) -> None:
    @app.exception_handler(UserError)
    async def refuse(request: Request, error: UserError) -> Response:
        return JSONResponse({"detail": str(error)}, 422)

    @app.exception_handler(RequestValidationError)
    async def misread(request: Request, error: RequestValidationError) -> Response:
        first = error.errors()[0]
        place = ".".join(str(part) for part in first["loc"])
        return JSONResponse({"detail": f"{place}: {first['msg']}"}, 422)


def _add_nodes(app: FastAPI, desk: Desk) -> None:
    @app.get("/nodes", response_model=list[NodeName])
    async def nodes() -> Any:
        """The nodes there are, in the order in which they hear a frame."""
        return Json(await desk.ask(lambda: [node_name(node) for node in desk.segment.nodes]))

    @app.get("/nodes/{node:path}", response_model=NodeState)
    async def state(node: str) -> Any:
        """How a node is at this moment."""
        found = desk.node(node)
        return Json(await desk.ask(lambda: node_state(found)))


def _add_orders(app: FastAPI, desk: Desk) -> None:
    @app.post("/nodes/{node:path}/faults/{fault}", response_model=Done)
    async def inject(node: str, fault: str, parameters: Given) -> Any:
        """Let something go wrong; a fault that is active already is replaced."""
        return await desk.order(await desk.fault(node, fault), "inject", fault, parameters)

    @app.delete("/nodes/{node:path}/faults/{fault}", response_model=Done)
    async def clear(node: str, fault: str) -> Any:
        """Take one fault away."""
        return await desk.order(await desk.fault(node, fault), "clear", fault)

    @app.delete("/nodes/{node:path}/faults", response_model=Done)
    async def clear_all(node: str) -> Any:
        """Take every fault away."""
        return await desk.order(desk.node(node), "clear", None)

    @app.patch("/nodes/{node:path}/settings", response_model=Done)
    async def change(node: str, settings: Given) -> Any:
        """Change live settings; of a device that a file describes also what it measures."""
        return await desk.order(desk.node(node), "set", settings)

    @app.put("/nodes/{node:path}/power", response_model=Done)
    async def power(node: str, power: Power) -> Any:
        """Switch the supply on or off."""
        found = desk.node(node)
        if power.on:
            return await desk.order(found, "power_on", power.settings)
        if power.settings:
            raise UserError("settings are taken over when the power comes, not when it goes")
        return await desk.order(found, "power_off")
