"""Protocol level, SDO: accesses to an object go wrong, at the initiate or in a segment."""

from collections.abc import Mapping

from simulators.faults import Parameter
from simulators.mischief.aim import ACCESS, OBJECT, SEGMENT
from simulators.mischief.conversation import READ
from simulators.mischief.disturbance import Kind
from simulators.mischief.effects import altered, late, lost
from simulators.mischief.sdo_filters import (
    Refusal,
    SdoFilter,
    Stall,
    Unlocked,
    other_index,
    other_size,
    other_toggle,
)
from simulators.mischief.turn import AIM

GENERAL_ERROR = 0x0800_0000
SECONDS = Parameter("by how much, in s", 1.0, low=0)
INITIATE: Mapping[str, Parameter] = {**OBJECT, **ACCESS, **AIM}
ANYWHERE: Mapping[str, Parameter] = {**OBJECT, **ACCESS, **SEGMENT, **AIM}
LATER = {"segment": Parameter("n: the n-th request after the initiate", 1, int, low=1)}

SDO: Mapping[str, Kind] = {
    "sdo_abort": Kind(
        "An access is refused with an abort code; nothing is read or written.",
        "The abort code; the object as it was.",
        {
            "code": Parameter("abort code", GENERAL_ERROR, int, low=0, high=0xFFFF_FFFF),
            **ANYWHERE,
        },
        Refusal,
    ),
    "sdo_silence": Kind(
        "An access is carried out, but its answer never comes.",
        "A time-out; what was written is written.",
        ANYWHERE,
        lambda place, **aim: SdoFilter(place, lost, **aim),
    ),
    "sdo_late": Kind(
        "An answer comes late, if you like after the time-out of the master.",
        "A slow answer; after a time-out one that belongs to no request, or to the next.",
        {"seconds": SECONDS, **ANYWHERE},
        lambda place, seconds, **aim: SdoFilter(place, late(seconds), **aim),
    ),
    "sdo_wrong_index": Kind(
        "The answer to an initiate names the next index.",
        "An answer that is not its own: to be ignored or aborted, its value not to be used.",
        INITIATE,
        lambda place, **aim: SdoFilter(place, altered(other_index), **aim),
    ),
    "sdo_wrong_toggle": Kind(
        "The answer to a segment has the toggle bit of the one before.",
        "A protocol error: the master aborts with 0x05030000.",
        {**OBJECT, **ACCESS, **LATER, **AIM},
        lambda place, **aim: SdoFilter(place, altered(other_toggle), **aim),
    ),
    "sdo_wrong_size": Kind(
        "The answer to a read announces another size than its data have.",
        "A value of the wrong length, or a transfer that ends early: an error, no value.",
        {"by": Parameter("how many bytes too many", -1, int), **OBJECT, **AIM},
        lambda place, by, **aim: SdoFilter(place, other_size(by), access=READ, **aim),
    ),
    "sdo_stall": Kind(
        "A transfer stands still from a segment on.",
        "A time-out in the middle of a transfer: an abort, and a new start.",
        {**OBJECT, **ACCESS, **LATER, **AIM},
        lambda place, **aim: Stall(place, lost, **aim),
    ),
    "sdo_in_wrong_state": Kind(
        "SDO is answered while the node is stopped (CiA 301 forbids it).",
        "Answers it has no right to; a stopped node is not to be taken for a running one.",
        INITIATE,
        Unlocked,
    ),
}
