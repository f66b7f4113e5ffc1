"""The control port in HTTP: every path, what it takes, and what it answers."""

import asyncio
import json
from importlib.metadata import version
from typing import Annotated, Any

from fastapi import Body, FastAPI, HTTPException, Query, Request
from fastapi.exceptions import RequestValidationError
from pydantic import BaseModel, Field
from starlette.responses import HTMLResponse, JSONResponse, Response

from canopen_twins.bench.twin import each_value
from canopen_twins.bus.frame import Frame
from canopen_twins.diagnosis.expected import ExpectedValues
from canopen_twins.diagnosis.why import why, why_frame
from canopen_twins.errors import UserError, unknown
from canopen_twins.files.shipped import scenario_file, scenarios
from canopen_twins.live.control import schema, view
from canopen_twins.live.control.desk import Desk
from canopen_twins.live.control.events import KEPT, KINDS
from canopen_twins.live.control.page import page
from canopen_twins.live.control.schema import SCALARS, Done, Scalar
from canopen_twins.live.control.stream import EventStream, Wanted
from canopen_twins.scenario.started import read_text
from canopen_twins.slave.dictionary import Objects

DESCRIPTION = "Hands on the running twins of a bus: what is done takes effect between two frames."
REFUSALS: dict[int | str, dict[str, Any]] = {
    404: {"model": schema.Refusal, "description": "No such node or fault"},
    422: {"model": schema.Refusal, "description": "A wrong name or value, in one line"},
    503: {"model": schema.Refusal, "description": "The twins do not answer, or too many watch"},
}
RECENT = 20  # frames that `why` looks at

Given = Annotated[dict[str, Scalar], Body(default_factory=dict)]
Names = Annotated[list[str], Query(default_factory=list)]


class Power(BaseModel, extra="forbid", strict=True):
    """The supply of a node."""

    on: bool
    settings: dict[str, Scalar] = Field(default_factory=dict)
    """Other settings to be switched on with."""


class Start(BaseModel, extra="forbid", strict=True):
    """A scenario: the name of one that is shipped, or with the text of a file."""

    name: str = "scenario.yaml"
    text: str | None = None


class Json(Response):
    """What `schema` says, as it is: nothing walks through it a second time."""

    media_type = "application/json"

    def render(self, content: Any) -> bytes:
        """Dataclasses are objects."""
        return json.dumps(content, default=vars).encode()


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
    _add_parts(app, desk)
    _add_why(app, desk)
    _add_bus(app, desk)
    _add_scenario(app, desk)
    _add_panel(app)
    _add_nodes(app, desk)  # the last: its path would take those of the others for names
    app.openapi()  # made once, before a twin has anything to answer
    return app


def _add_errors(app: FastAPI) -> None:
    @app.exception_handler(UserError)
    async def refuse(request: Request, error: UserError) -> Response:
        return JSONResponse({"detail": str(error)}, 422)

    @app.exception_handler(Exception)
    async def fail(request: Request, bug: Exception) -> Response:
        return JSONResponse({"detail": f"a bug: {type(bug).__name__}: {bug}"}, 500)

    @app.exception_handler(RequestValidationError)
    async def misread(request: Request, error: RequestValidationError) -> Response:
        first = error.errors()[0]
        *path, last = first["loc"]
        if is_scalar := last in SCALARS:  # what is wrong with the first of them is no answer
            last = path.pop()
        place = ".".join(map(str, [*path, last]))
        wanted = "a number, a text, true, false or null is wanted here"
        return JSONResponse({"detail": f"{place}: {wanted if is_scalar else first['msg']}"}, 422)


def _add_orders(app: FastAPI, desk: Desk) -> None:
    @app.post("/nodes/{node:path}/faults/{fault}", response_model=Done)
    async def inject(node: str, fault: str, parameters: Given) -> Any:
        """Let something go wrong; a fault that is active already is replaced."""
        return Json(await desk.order(await desk.fault(node, fault), "inject", fault, parameters))

    @app.delete("/nodes/{node:path}/faults/{fault}", response_model=Done)
    async def clear(node: str, fault: str) -> Any:
        """Take one fault away."""
        return Json(await desk.order(await desk.fault(node, fault), "clear", fault))

    @app.delete("/nodes/{node:path}/faults", response_model=Done)
    async def clear_all(node: str) -> Any:
        """Take every fault away."""
        return Json(await desk.order(desk.node(node), "clear", None))

    @app.patch("/nodes/{node:path}/settings", response_model=Done)
    async def change(node: str, settings: Given) -> Any:
        """Change live settings; of a device that a file describes also what it measures."""
        return Json(await desk.order(desk.node(node), "set", settings))

    @app.put("/nodes/{node:path}/power", response_model=Done)
    async def power(node: str, power: Power) -> Any:
        """Switch the supply on, with other settings if any are given, or off."""
        found = desk.node(node)
        if power.on:
            return Json(await desk.order(found, "power_on", power.settings))
        if power.settings:
            raise UserError("settings are taken over when the power comes, not when it goes")
        return Json(await desk.order(found, "power_off"))


def _add_parts(app: FastAPI, desk: Desk) -> None:
    @app.get("/nodes/{node:path}/faults", response_model=schema.Faults)
    async def faults(node: str) -> Any:
        """What can go wrong with a node, and what has."""
        found = desk.node(node)
        known, active = await desk.ask(lambda: (found.faults.known, view.active_faults(found)))
        return Json(schema.Faults(view.known_faults(known), active))

    @app.get("/nodes/{node:path}/settings", response_model=list[schema.Setting])
    async def settings(node: str) -> Any:
        """Every setting with its value and what it takes."""
        return Json(view.node_settings(desk.node(node)))

    @app.get("/nodes/{node:path}/values", response_model=dict[str, Any])
    async def values(node: str, name: Names) -> Any:
        """Entries of the dictionary by name or address, read without a frame; all of them if none
        is named. What a master could not read is left out; bytes are told in hex."""
        values = await desk.collect(each_value(desk.node(node), name))
        return Json({name: view.plain(value) for name, value in values})

    @app.get("/nodes/{node:path}/objects", response_model=list[schema.ObjectEntry])
    async def objects(node: str) -> Any:
        """The object dictionary in force; nothing while the node is silent."""
        return Json(await desk.collect(view.objects(desk.node(node))))


def _add_why(app: FastAPI, desk: Desk) -> None:
    @app.get("/nodes/{node:path}/why", response_model=list[str])
    async def reasons(node: str, frame: str | None = None, object: str | None = None) -> Any:
        """Why a node answered as it did lately; or what was out of the ordinary with a frame, one
        of the last 500, in the notation of cansend; or what keeps an object from its effect."""
        found, records = desk.node(node), desk.events.records
        if frame is not None:
            told = Frame.parse(frame)
            return Json(await desk.ask(lambda: why_frame(found, [*records], told)))
        if object is None:
            return Json(await desk.ask(lambda: why(found, [*records][-RECENT:])))
        expected = ExpectedValues([_address(desk, node, object)])
        return Json(await desk.ask(lambda: why(found, (), expected=expected)))


def _address(desk: Desk, node: str, name: str) -> tuple[int, int]:
    """Raises `UserError` if there is no such object."""
    variable = Objects(desk.node(node).dictionary).find(name)
    return variable.index, variable.subindex


def _add_bus(app: FastAPI, desk: Desk) -> None:
    @app.get("/frames", response_model=list[schema.FrameEvent])
    async def frames(last: Annotated[int, Query(ge=1, le=KEPT)] = 50, after: int = -1) -> Any:
        """The last frames of the bus, decoded; those after a moment, which costs less."""
        records = await desk.ask(lambda: desk.events.last(last, after))
        return Json(await desk.collect(map(desk.events.words, records)))

    @app.get("/events", response_model=schema.Event, response_class=EventStream)
    async def events(kind: Names, node: Names) -> Any:
        """Server-sent events, as they come: those of some kinds, and of some nodes, or all."""
        for each in kind:
            if each not in KINDS:
                raise unknown("kind", each, KINDS)
        names = {desk.node(each).wire.name for each in node}
        if desk.streams.full:
            raise HTTPException(503, "too many watch already")
        return EventStream(desk.streams.watch(Wanted(set(kind) or KINDS, names)))


def _add_scenario(app: FastAPI, desk: Desk) -> None:
    @app.post("/scenario", response_model=Done)
    async def start(start: Start) -> Any:
        """Start a scenario beside the master, one at a time."""
        text = start.text if start.text is not None else _shipped(start.name)
        scenario = await asyncio.to_thread(read_text, start.name, text, desk.segment.nodes)
        moment = await desk.ask(lambda: desk.scenarios.start(scenario, text))
        desk.look_after_scenario()
        return Json(Done(moment))

    @app.get("/scenarios", response_model=list[str])
    async def names() -> Any:
        """The scenarios that are shipped."""
        return Json(sorted(scenarios()))

    @app.get("/scenario", response_model=schema.ScenarioRun | None)
    async def told() -> Any:
        """The scenario of the run, or the last one that was started, and its verdict."""
        return Json(await desk.ask(lambda: desk.scenarios.told))

    @app.delete("/scenario", response_model=Done)
    async def stop() -> Any:
        """End it before its time; its cleanup is carried out."""
        return Json(Done(await desk.ask(desk.scenarios.stop)))


def _add_panel(app: FastAPI) -> None:
    @app.get("/", include_in_schema=False)
    async def panel() -> Any:
        """For people, in a browser."""
        html, policy = page()
        return HTMLResponse(html, headers={"Content-Security-Policy": policy})


def _shipped(name: str) -> str:
    if name not in scenarios():
        raise unknown("shipped scenario", name, scenarios())
    with scenario_file(name) as path:
        return path.read_text("utf-8")


def _add_nodes(app: FastAPI, desk: Desk) -> None:
    @app.get("/nodes", response_model=list[schema.NodeName])
    async def nodes() -> Any:
        """The nodes there are, in the order in which they hear a frame."""
        return Json(await desk.ask(lambda: [*map(view.node_name, desk.nodes.values())]))

    @app.get("/nodes/{node:path}", response_model=schema.NodeState)
    async def state(node: str) -> Any:
        """How a node is at this moment."""
        found = desk.node(node)
        return Json(await desk.ask(lambda: view.node_state(found)))
