"""What the control port tells as it happens: frames, why they were refused, states, orders."""

import asyncio
import logging
from contextlib import ExitStack
from itertools import islice

import pytest

from canopen_twins import Bench
from canopen_twins.live.control.events import Events
from canopen_twins.live.control.stream import ROOM, Streams, Wanted
from canopen_twins.live.orders import Orders

REFUSED = "605#2B1020000F270000"  # Run command = 9999


def test_frames_are_decoded(port):
    with port.events("?kind=frame") as events, port.master() as send:
        send("605#4000100000000000")
        request, answer = islice(events, 2)
    assert request["node"] == ""
    assert request["frame"] == "605#4000100000000000"
    assert request["words"] == "SDO read 0x1000:00 Device Type"
    assert answer["node"] == "topcon"
    assert answer["words"].startswith("SDO answer 0x1000:00 Device Type = ")
    assert answer["moment"] >= request["moment"] > 0


def test_a_refusal_comes_with_its_reason_which_can_be_asked_for_later_too(port):
    with port.events("?kind=frame&node=topcon") as events, port.master() as send:
        send(REFUSED)
        (answer,) = islice(events, 1)
    assert answer["why"][0].startswith(f"{REFUSED} refused: ")
    frame = answer["frame"].replace("#", "%23")
    assert port.get(f"/nodes/topcon/why?frame={frame}").body == answer["why"]
    assert answer["why"][0] in port.get("/nodes/topcon/why").body
    told = [frame["frame"] for frame in port.get("/frames?last=9").body]
    assert told[told.index(REFUSED) + 1] == answer["frame"]


def test_what_keeps_an_object_from_its_effect_is_told(port):
    told = port.get("/nodes/topcon/why?object=Run%20command").body
    assert any("Run command" in reason for reason in told)


def test_orders_states_and_emergencies_are_told(port):
    with port.events("?kind=order&kind=state&kind=emcy&node=topcon") as events:
        port("POST", "/nodes/topcon/faults/interlock_open")
        port("PUT", "/nodes/topcon/power", {"on": False})
        port("PUT", "/nodes/topcon/power", {"on": True})
        told = [(event["kind"], event["words"]) for event in islice(events, 6)]
    assert told[0] == ("order", "inject interlock_open")
    assert told[1][0] == "emcy"
    assert told[1][1].startswith("EMCY ")
    assert told[2:5] == [("order", "power off"), ("state", "initialising"), ("order", "power on")]


@pytest.mark.parametrize(
    ("query", "status", "detail"),
    [("?kind=frames", 422, "did you mean 'frame'?"), ("?node=x", 404, "unknown node 'x'")],
)
def test_what_cannot_be_watched_is_told(port, query, status, detail):
    answer = port.get(f"/events{query}")
    assert answer.status == status
    assert detail in answer.body["detail"]


def test_nobody_watches_more_than_there_is_room_for(port):
    with ExitStack() as stack:
        for _ in range(16):
            stack.enter_context(port.events())
        assert port.get("/events") == (503, {"detail": "too many watch already"})
    for _ in range(100):
        if port.get("/events?kind=x").status == 422:
            break


def test_who_takes_nothing_is_dropped_while_others_hear_all():
    bench = Bench("topcon", node_id=5)
    orders = Orders()
    streams = Streams(Events(bench.segment, orders))

    async def run():
        slow, quick = (streams.watch(Wanted(["frame"])) for _ in range(2))
        for each in (slow, quick):
            await anext(each)
        heard = 0
        for _ in range(ROOM // 250 + 1):
            for _ in range(125):
                bench.send("605#4000100000000000")
                while orders.waiting:
                    orders.carry_out()
            heard += (await anext(quick)).count("event: frame\n")
        assert heard > ROOM
        with pytest.raises(StopAsyncIteration):
            await anext(slow)
        await quick.aclose()

    asyncio.run(run())
    assert not +streams._events.watched


def test_who_wants_emergencies_alone_has_no_other_frame_decoded():
    bench = Bench("topcon", node_id=5)
    orders = Orders()
    events = Events(bench.segment, orders)
    events.watched["emcy"] = 1
    bench.send("605#4000100000000000")
    assert not orders.waiting
    bench.inject("error", number=0x23)
    while orders.waiting:
        orders.carry_out()
    assert [event.kind for event in events.take()] == ["frame", "emcy"]


def test_frames_that_somebody_has_are_left_out(port):
    with port.events("?kind=frame") as events, port.master() as send:
        send("605#4000100000000000")
        request, answer = islice(events, 2)
    told = port.get(f"/frames?last=500&after={request['moment']}").body
    moments = [frame["moment"] for frame in told]
    assert answer["moment"] in moments or answer["moment"] == request["moment"]
    assert min(moments, default=answer["moment"]) >= request["moment"]
    assert request["frame"] not in [frame["frame"] for frame in told]


def test_without_a_watcher_nothing_is_decoded():
    bench = Bench("topcon", node_id=5)
    orders = Orders()
    events = Events(bench.segment, orders)
    bench.send("605#4000100000000000")
    assert not orders.waiting
    assert [str(record.frame) for record in events.records][-2] == "605#4000100000000000"


def test_what_people_are_warned_of_is_told_too(port):
    with port.events("?kind=note") as events:
        logging.getLogger("canopen_twins.live.serve").warning("%.1f s are left out", 2)
        assert next(events)["words"] == "2.0 s are left out"
