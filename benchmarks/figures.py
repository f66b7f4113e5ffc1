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
PYYAML = "`yaml.safe_load`"
LOCAL_NODE = "`LocalNode` on `virtual`"

SECTIONS = {
    "A master and a twin": [
        Figure(
            f"SDO upload of {what}, {where}",
            f"test_upload_{place}[{name}]",
            LOCAL_NODE,
            f"test_upload_localnode_virtual[{name}]",
            goal,
        )
        for place, where, goal in (
            ("bench", "in the bench", Goal(ratio=2.5)),
            ("served_virtual", "served on `virtual`", Goal(ratio=1.0)),
        )
        for name, what in (("memory", "a value in memory"), ("measured", "a measured value"))
    ],
    "A twin of a file": [
        Figure(
            "SDO upload, served on `virtual`",
            "test_upload_file_twin",
            LOCAL_NODE,
            "test_upload_file_localnode",
            Goal(ratio=1.0),
        ),
        Figure(
            "reading a file of 1,000 entries",
            "test_read[reader]",
            "`canopen.import_od`",
            "test_read[import_od]",
            Goal(ratio=1.2),
        ),
        Figure(
            "127 twins, 60 s: heartbeat 1 s, TPDO with a SYNC every 100 ms",
            "test_many",
            "real time",
            60.0,
            Goal(time=3.0),
        ),
    ],
    "One frame in a node": [
        Figure(
            "frame that nobody wants",
            "test_frame_twin[foreign]",
            "the same",
            "test_frame_localnode[foreign]",
        ),
        Figure("SDO upload request", "test_frame_twin[upload]", "the same", FRAME, Goal(ratio=0.8)),
        Figure(
            "SDO download request",
            "test_frame_twin[download]",
            "the same",
            "test_frame_localnode[download]",
        ),
        Figure("RPDO with one value", "test_frame_twin[rpdo]", UPLOAD, FRAME),
        Figure("remote request, TPDO as of the last SYNC", "test_frame_twin[rtr]", UPLOAD, FRAME),
        Figure(
            "SYNC, TPDO of type 1 with four values",
            "test_frame_twin[sync]",
            UPLOAD,
            FRAME,
            Goal(ratio=0.6),
        ),
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
            "10 s of a settled output, SDO upload every 10 ms",
            "test_questions",
            "real time",
            10.0,
        ),
        Figure(
            "10 s, new set value every 100 ms, resistor",
            "test_set_values[resistor 4]",
            "real time",
            10.0,
        ),
        Figure(
            "10 s, new set value every 100 ms, inductor",
            "test_set_values[inductor 4 0.1]",
            "real time",
            10.0,
            Goal(time=0.06),
        ),
        Figure(
            "10 s, RPDO, SYNC and TPDO every 10 ms, inductor",
            "test_control_loop",
            "real time",
            10.0,
        ),
        Figure(
            "20 minutes of a charger's calibration, TPDOs every 500 ms",
            "test_calibration",
            "real time",
            1200.0,
            Goal(time=1.0),
        ),
        Figure(
            "20 minutes of a gateway in Operational, 75 TPDOs a second",
            "test_governing",
            "real time",
            1200.0,
            Goal(time=1.0),
        ),
    ],
    "Scenarios": [
        Figure(
            "the largest file of the library",
            "test_file[load-library]",
            PYYAML,
            "test_file[pyyaml-library]",
        ),
        Figure(
            "the longest file there can be",
            "test_file[load-longest]",
            PYYAML,
            "test_file[pyyaml-longest]",
        ),
        Figure("all of the TopCon, played", "test_play", "simulated time", 683.0),
    ],
    "A hunt": [
        Figure(
            "one run, 30 s of a TopCon and its master",
            "test_run",
            "real time",
            30.0,
            Goal(time=0.05),
        ),
        Figure(
            "60 such runs by two workers",
            "test_workers[2]",
            "by one",
            "test_workers[1]",
            Goal(ratio=1.8),
        ),
    ],
    "Start": [
        Figure(
            "twin made and read, every one but the first",
            "test_later_twin",
            LOCAL_NODE,
            "test_later_localnode",
            Goal(time=0.020),
        ),
        Figure(
            "the first of a process that has imported canopen",
            "test_fresh[first-twin]",
            LOCAL_NODE,
            "test_fresh[first-localnode]",
            Goal(time=0.020),
        ),
        Figure(
            "`from canopen_twins import Bench`",
            "test_fresh[import-bench]",
            "`import canopen`",
            "test_fresh[import-canopen]",
            Goal(ratio=0.71),
        ),
        Figure(
            "`import canopen_twins`",
            "test_fresh[import-canopen_twins]",
            "`import canopen`",
            "test_fresh[import-canopen]",
        ),
        Figure(
            "`canopen-twin run topcon` to its ready line, process and all",
            "test_first_line[run]",
            "a process that imports canopen",
            "test_first_line[canopen]",
            Goal(time=0.5),
        ),
        Figure(
            "`canopen-twin play` of a short scenario to its first line, process and all",
            "test_first_line[play]",
            "a process that imports canopen",
            "test_first_line[canopen]",
        ),
        Figure(
            "the pytest plugin, in a run that does not use it",
            "test_fresh[import-plugin]",
            "`import canopen`",
            "test_fresh[import-canopen]",
        ),
    ],
    "In a pytest session": [
        Figure(
            "a TopCon by `canopen_bench` in the first test",
            "test_session[first]",
            LOCAL_NODE,
            "test_fresh[first-localnode]",
            Goal(time=0.020),
        ),
        Figure(
            "the same in every later test",
            "test_session[later]",
            LOCAL_NODE,
            "test_later_localnode",
            Goal(time=0.020),
        ),
        Figure(
            "the end of the collection before them",
            "test_session[collection]",
            "`import canopen`",
            "test_fresh[import-canopen]",
        ),
        Figure(
            "a run of one test, process and all",
            "test_process[topcon]",
            "a test of nothing",
            "test_process[request]",
        ),
    ],
}
