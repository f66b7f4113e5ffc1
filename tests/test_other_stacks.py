import pytest
from probe import Probe

from canopen_twins import Bench, devices

# What CANopenNode and Lely answer to the same frame, None for silence.
# Where they agree that is the answer; where they do not, it is one of the two.
ANSWERS = {
    "605#6000000000000000": ("8000000001000405",) * 2,  # a segment of no transfer
    "605#0000000000000000": ("8000000001000405",) * 2,
    "605#E000000000000000": ("8000000001000405",) * 2,  # no command
    "605#4017100100000000": ("8017100111000906",) * 2,  # a sub-index of a plain variable
    "605#2300100101000000": ("8000100111000906",) * 2,
    "605#2F17100001000000": ("8017100013000706",) * 2,  # one byte for two
    "605#2317100001000000": ("8017100012000706",) * 2,  # four bytes for two
    "605#22171000E8030000": ("6017100000000000", "8017100012000706"),  # does not say how many
    "605#4000": (None, "8000000000000206"),  # shorter than a request
    "00000605#4000100000000000": (None,) * 2,  # the same number, but of 29 bits
    "000#01": (None,) * 2,  # NMT: too short, no command, not for us
    "000#7705": (None,) * 2,
    "000#0106": (None,) * 2,
    "705#R": (None,) * 2,  # node guarding
}

OTHERWISE = {
    # gateway, 5.2: no object can be written over CANopen
    ("gateway", "605#22171000E8030000"): ("8017100002000106",),
}
"""What a device answers otherwise, by device and frame, each with the place in its manual."""


@pytest.mark.parametrize(("frame", "answers"), ANSWERS.items())
@pytest.mark.parametrize("device", ["probe", *devices.names()])
def test_a_frame_is_answered_as_other_stacks_do(device, frame, answers):
    bench = Bench.of({"probe": Probe()}) if device == "probe" else Bench(device, node_id=5)
    bench.run(1.0)  # some take their time to boot
    (answer,) = bench.send(frame) or [None]
    expected = OTHERWISE.get((device, frame), answers)
    assert answer in [data and f"585#{data}" for data in expected]
