"""Which benchmark is compared with which, and what is aimed at."""

from typing import NamedTuple


class Goal(NamedTuple):
    """What a figure should reach: a ratio to its peer, a time in seconds, or both."""

    ratio: float | None = None
    time: float | None = None


class Figure(NamedTuple):
    """One line of the report; `twin` and `peer` are names of benchmarks."""

    what: str
    twin: str
    against: str
    peer: str | float
    """A number is the time in seconds that the same takes in real time."""
    goal: Goal = Goal()


UPLOAD = "an SDO upload request"
FRAME = "test_frame_localnode[upload]"

SECTIONS = {
    "A master and a twin": [
        Figure(
            "SDO upload by `RemoteNode`, in the bench",
            "test_upload_bench",
            "`LocalNode` on `virtual`",
            "test_upload_localnode_virtual",
            Goal(ratio=2.5),
        ),
        Figure(
            "SDO upload by `RemoteNode`, served on `virtual`",
            "test_upload_served_virtual",
            "`LocalNode` on `virtual`",
            "test_upload_localnode_virtual",
            Goal(ratio=1.0),
        ),
    ],
    "One frame in a node": [
        Figure(
            "frame that nobody wants",
            "test_frame_twin[foreign]",
            "the same",
            "test_frame_localnode[foreign]",
        ),
        Figure("SDO upload request", "test_frame_twin[upload]", "the same", FRAME),
        Figure(
            "SDO download request",
            "test_frame_twin[download]",
            "the same",
            "test_frame_localnode[download]",
        ),
        Figure("RPDO", "test_frame_twin[rpdo]", UPLOAD, FRAME),
        Figure("remote request, TPDO", "test_frame_twin[rtr]", UPLOAD, FRAME),
        Figure("SYNC, TPDO of type 1", "test_frame_twin[sync]", UPLOAD, FRAME),
    ],
    "Simulated time": [
        Figure(
            "an hour of a settled output, heartbeat 1 s",
            "test_settled_hour",
            "real time",
            3600.0,
            Goal(time=1.0),
        ),
        Figure(
            "a minute, new set value every 100 ms, resistor",
            "test_minute_of_set_values[resistor 4]",
            "real time",
            60.0,
        ),
        Figure(
            "a minute, new set value every 100 ms, inductor",
            "test_minute_of_set_values[inductor 4 0.1]",
            "real time",
            60.0,
        ),
        Figure(
            "a minute, RPDO, SYNC and TPDO every 10 ms, inductor",
            "test_minute_of_control_loop",
            "real time",
            60.0,
        ),
    ],
    "Start": [
        Figure(
            "twin made and read, every one but the first",
            "test_later_twin",
            "`LocalNode` on `virtual`",
            "test_later_localnode",
            Goal(time=0.020),
        ),
        Figure(
            "the first of a process that has imported canopen",
            "test_fresh[first-twin]",
            "`LocalNode` on `virtual`",
            "test_fresh[first-localnode]",
            Goal(time=0.020),
        ),
        Figure(
            "`from simulators import Bench`",
            "test_fresh[import-bench]",
            "`import canopen`",
            "test_fresh[import-canopen]",
        ),
        Figure(
            "`import simulators`",
            "test_fresh[import-simulators]",
            "`import canopen`",
            "test_fresh[import-canopen]",
        ),
        Figure(
            "the pytest plugin, in a run that does not use it",
            "test_fresh[import-plugin]",
            "`import canopen`",
            "test_fresh[import-canopen]",
        ),
    ],
}
