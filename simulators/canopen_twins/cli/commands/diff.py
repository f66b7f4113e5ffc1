"""Two runs side by side."""

import argparse

from canopen_twins.cli.exit_codes import FAILED, OK
from canopen_twins.record import Side, differences


def diff(options: argparse.Namespace) -> int:
    """Whether they are the same, or the first difference in words."""
    same, told = differences(Side.of("A", options.a), Side.of("B", options.b))
    print(told)
    return OK if same else FAILED
