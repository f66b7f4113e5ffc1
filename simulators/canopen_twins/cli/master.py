"""What commands share that run a master: how it is named, and whether it can be run at all."""

from dataclasses import replace

from canopen_twins.bench.python_master import PythonMaster
from canopen_twins.cli.command import Parser
from canopen_twins.scenario import Scenario


def add_master(parser: Parser) -> None:
    """Who is tested."""
    parser.add_argument(
        "--master",
        metavar="MODULE:FUNCTION",
        help="a master in Python, run as it is in simulated time; goes before that of the file",
    )


def with_master(scenario: Scenario, name: str | None) -> Scenario:
    """The same scenario with this master, or else with that of its file.

    Raises:
        UserError: it cannot be run.
    """
    if name is not None:
        master = PythonMaster.beside(name, scenario.file)
        scenario = replace(scenario, master=master, master_line=1)
    if scenario.master is not None:
        scenario.master.check()
    return scenario
