"""What holds for every device, the ones still to be written included."""

import re
from pathlib import Path

import pytest

import canopen_twins
from canopen_twins import Bench, devices

DEVICES = Path(canopen_twins.__path__[0]) / "devices"
MODELS = sorted(DEVICES.glob("*/model/**/*.py"))
BOOT_TIME = 10.0  # seconds; some take their time
TYPICAL = {int: 1, float: 1.0, str: "1"}
VALUES = {  # of parameters for which a typical value is none
    ("charger", "supply"): {"volts": 12.0},
    ("charger", "error"): {"key": "hardware"},
    ("charger", "warning"): {"number": 1},
    ("topcon", "supply"): {"rail": "24V", "volts": 18.0},
    ("topcon", "lasting_error"): {"number": 0x23},
}


@pytest.fixture(params=devices.names())
def bench(request):
    """A bench with a device that has booted."""
    bench = Bench(request.param)
    bench.run(BOOT_TIME)
    return bench


def entries(bench):
    """Every entry of the dictionary in force."""
    return [entry for subs in bench.twin.node.slave.entries.values() for entry in subs.values()]


def sdo(bench, command, entry):
    """Send an SDO request without data; what comes back."""
    node_id = bench.twin.node.node_id
    index, subindex = entry.address
    request = bytes([command, index & 0xFF, index >> 8, subindex]).hex()
    return bench.send(f"{0x600 + node_id:03X}#{request}00000000")


def test_it_boots_once_and_waits_in_pre_operational(bench):
    node_id = bench.twin.node.node_id
    assert bench.sent.count(f"{0x700 + node_id:03X}#00") == 1
    assert bench.twin.node.state == "PRE-OPERATIONAL"


def test_every_entry_can_be_read_unless_it_is_write_only(bench):
    for entry in entries(bench):
        (answer,) = sdo(bench, 0x40, entry)
        aborted = answer[4:6] == "80"
        assert aborted is not entry.readable, f"{entry.variable}: {answer}"
        if aborted:
            assert answer.endswith("01000106")  # 06010001h, attempt to read a write-only object


def test_no_entry_that_is_read_only_can_be_written(bench):
    for entry in entries(bench):
        if not entry.writable:
            before = entry.read()
            (answer,) = sdo(bench, 0x22, entry)
            assert answer[4:6] == "80", f"{entry.variable}: {answer}"
            assert entry.read() == before


def test_what_is_written_unchanged_is_taken_or_refused_in_words(bench):
    node_id = bench.twin.node.node_id
    for entry in entries(bench):
        if entry.writable and entry.readable and (entry.size or 9) <= 4:
            data = entry.read()
            index, subindex = entry.address
            head = bytes([0x23 | 4 - len(data) << 2, index & 0xFF, index >> 8, subindex])
            request = (head + data.ljust(4, b"\0")).hex()
            answers = bench.send(f"{0x600 + node_id:03X}#{request}")
            assert answers[0][4:6] in ("60", "80"), f"{entry.variable}: {answers}"


def test_it_is_silent_when_stopped_and_without_power(bench):
    node_id = bench.twin.node.node_id
    bench.send(f"000#02{node_id:02X}")
    request = f"{0x600 + node_id:03X}#4000100000000000"
    assert bench.send(request) == []
    bench.power_off()
    assert bench.send(request) == []
    assert bench.run(BOOT_TIME) == []
    bench.power_on()
    bench.run(BOOT_TIME)
    assert len(bench.send(request)) == 1


@pytest.mark.parametrize("command", ["81", "82"])
def test_it_boots_again_after_a_reset(bench, command):
    node_id = bench.twin.node.node_id
    boot_up = f"{0x700 + node_id:03X}#00"
    sent = bench.send(f"000#{command}{node_id:02X}") + bench.run(BOOT_TIME)
    assert sent.count(boot_up) == 1
    assert bench.twin.node.state == "PRE-OPERATIONAL"


@pytest.mark.parametrize("name", devices.names())
def test_a_minute_in_operational_gives_the_same_trace_every_time(name):
    def trace():
        bench = Bench(name)
        bench.run(BOOT_TIME)
        bench.send("000#0100")
        bench.run(60.0)
        return [str(record) for record in bench.trace]

    first = trace()
    assert len(first) > 1
    assert trace() == first


def faults(name):
    """Those of a device that can be cleared, each with the parameters that it has to be given."""
    for fault, told in devices.create(name).faults.items():
        if told.clear is not None:
            wanted = {key: each for key, each in told.parameters.items() if each.default is None}
            typical = {key: TYPICAL[each.kind] for key, each in wanted.items()}
            yield fault, VALUES.get((name, fault), typical)


def after(name, fault=None, given=None):
    """What is on the bus in 5 s after a fault of 2 s, and a device that is switched on anew."""
    bench = Bench(name)
    bench.run(BOOT_TIME)
    bench.send("000#0100")
    if fault is not None:
        bench.inject(fault, **given)
        assert list(bench.twin.node.faults.active) == [fault]
    bench.run(2.0)
    bench.clear()
    assert bench.twin.node.faults.active == {}
    bench.power_off()
    bench.run(1.0)
    bench.trace.clear()
    bench.power_on()
    bench.run(BOOT_TIME)
    bench.send("000#0100")
    bench.run(5.0)
    for entry in entries(bench):
        sdo(bench, 0x40, entry)
    return [str(record) for record in bench.trace]


@pytest.mark.parametrize("name", devices.names())
def test_no_fault_leaves_a_trace_once_it_is_cleared_and_the_device_is_switched_on_anew(name):
    undisturbed = after(name)
    assert {fault: after(name, fault, given) == undisturbed for fault, given in faults(name)} == {
        fault: True for fault, _ in faults(name)
    }


def test_its_report_is_in_words_and_numbers(bench):
    assert bench.device.report
    assert all(str(value) for value in bench.device.report.values())


def test_at_rest_it_costs_nothing(bench):
    steps = []
    step = bench.device.step
    bench.device.step = lambda dt: (steps.append(dt), step(dt))
    bench.run(600.0)
    assert sum(steps) <= 600.0 + bench.device.cycle
    assert len(steps) < 600 / bench.device.cycle


@pytest.mark.parametrize("model", MODELS, ids=lambda path: str(path.relative_to(DEVICES)))
def test_a_model_knows_nothing_of_can_nor_of_ours_nor_of_the_wall(model):
    text = model.read_text("utf-8")
    imports = re.findall(r"^\s*(?:from|import) ([\w.]+)", text, re.MULTILINE)
    own = f"canopen_twins.devices.{model.relative_to(DEVICES).parts[0]}.model"
    foreign = [name for name in imports if name.startswith(("can", "canopen_twins"))]
    assert [name for name in foreign if not name.startswith(own)] == []
    assert not set(imports) & {"time", "datetime", "threading"}


@pytest.mark.parametrize("name", devices.names())
def test_it_says_who_it_is(name):
    assert devices.find(name).title
    assert devices.find(name).eds
