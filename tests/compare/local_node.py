"""canopen's LocalNode as the device, on a bus of python-can, and what a master asks it."""

import time
from contextlib import contextmanager
from pathlib import Path

import can
import canopen

from canopen_twins.bus.clock import microseconds
from canopen_twins.bus.frame import Frame
from canopen_twins.bus.python_can import frame_of, message_of

BLOCK = Path(__file__).parents[2] / "docs/examples/io-block/io_block.eds"
QUIET = 0.2  # seconds from a request to the next; a busy machine answers late
MORE = {
    0x1008: ("Manufacturer device name", 0x9, "const", "DefaultValue=An I/O block"),
    0x100C: ("Guard time", 0x6, "rw", "DefaultValue=0"),
    0x100D: ("Life time factor", 0x5, "rw", "DefaultValue=0"),
    0x2000: ("Ramp", 0x6, "rw", "DefaultValue=10\nLowLimit=1\nHighLimit=1000"),
    0x2001: ("Without a value", 0x7, "rw", ""),
}
VARIABLE = """
[{index:X}]
ParameterName={name}
ObjectType=0x7
DataType=0x{type:04X}
AccessType={access}
PDOMapping=0
{more}
"""
STORE = """
[1010]
ParameterName=Store parameters
ObjectType=0x8
SubNumber=2
[1010sub0]
ParameterName=Largest sub-index
ObjectType=0x7
DataType=0x0005
AccessType=const
DefaultValue=1
PDOMapping=0
[1010sub1]
ParameterName=Save all
ObjectType=0x7
DataType=0x0007
AccessType=rw
DefaultValue=1
PDOMapping=0
"""


def machine(path):
    """An EDS of a device with something of everything."""
    text = BLOCK.read_text("utf-8")
    count = int(text.split("[OptionalObjects]\nSupportedObjects=")[1].split("\n")[0])
    more = "".join(f"{count + n + 1}=0x{index:X}\n" for n, index in enumerate([*MORE, 0x1010]))
    head = f"[OptionalObjects]\nSupportedObjects={count}\n"
    assert head in text
    text = text.replace(head, head.replace(str(count), str(count + len(MORE) + 1)) + more)
    text = text.replace("LSS_Supported=0", "LSS_Supported=1")
    for index, (name, type_, access, default) in MORE.items():
        text += VARIABLE.format(index=index, name=name, type=type_, access=access, more=default)
    path.write_text(text + STORE, "utf-8")
    return path


@contextmanager
def local_node(eds, bus):
    """One that answers on a bus, as node 5."""
    network = canopen.Network()
    network.NOTIFIER_CYCLE = 0.01
    network.connect(**bus)
    try:
        node = canopen.LocalNode(5, str(eds))
        network.add_node(node)
        yield node
    finally:
        network.disconnect()


def asked(bus, frames):
    """What is on the bus while a master sends one frame after the other."""
    trace, begun = [], time.monotonic()

    def note(frame):
        trace.append((microseconds(time.monotonic() - begun), frame))

    with can.Bus(**bus) as master:
        for text in frames:
            frame = Frame.parse(text)
            note(frame)
            master.send(message_of(frame))
            end = time.monotonic() + QUIET
            while (left := end - time.monotonic()) > 0:
                if (message := master.recv(left)) is not None:
                    note(frame_of(message))
    return trace
