"""run --shadow: the twin beside the real device, which it only listens to."""

from __future__ import annotations

import argparse
import json

from canopen_twins.cli.bus import bus_of_run, hub_of_options
from canopen_twins.cli.command import FAILED, Signals
from canopen_twins.cli.participants import participants_of, title
from canopen_twins.cli.tolerances import tolerances
from canopen_twins.errors import UserError
from canopen_twins.live.shadow import shadow
from canopen_twins.record.compare.agreement import Difference
from canopen_twins.record.compare.report import account, summary

OF_A_TWIN_THAT_SENDS = {
    **{name: f"--{name}" for name in ("scenario", "nvram", "trace", "record", "control")},
    "tells": "--words",
    "words": "the COMMAND",
}


def run_shadow(options: argparse.Namespace, signals: Signals) -> int:
    """Listen until a signal comes; 1 if the device has differed from its twin.

    Raises:
        UserError: an option for twins that take part, or a bus that cannot be opened.
    """
    for name, told in OF_A_TWIN_THAT_SENDS.items():
        if getattr(options, name, None) not in (None, False, []):
            raise UserError(f"--shadow takes no part in anything: leave {told} out")
    nodes = participants_of(options, None)
    allowed = tolerances(options, nodes.values())
    options.real_bus = True  # it is there for the real device, and does nothing to it
    with hub_of_options(options) as hub:
        bus = bus_of_run(options, hub)
        ready = {"shadow": title(options, None), **bus.told}
        print(json.dumps(ready), flush=True)
        agreement = shadow(nodes, bus.open, lambda: bool(signals), _tell, allowed)
    print(summary(agreement))
    return FAILED if agreement.differences else signals.code


def _tell(difference: Difference) -> None:
    print("\n".join(account(difference)), flush=True)
