"""A command on a real vcan0."""

import argparse

from canopen_twins.bus import vcan as place


def vcan(options: argparse.Namespace) -> int:
    """Run it, and end as it ends; 124 when its time is up."""
    return place.run(options.words, options.limit, options.out)
