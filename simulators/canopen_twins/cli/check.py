"""check and schema: what the files of users may say, and what is wrong with those there are."""

import argparse
import json
import re
import sys
from collections.abc import Sequence
from dataclasses import fields
from os.path import relpath
from pathlib import Path

from canopen_twins import devices
from canopen_twins import scenario as rules
from canopen_twins.bench.bench import Bench
from canopen_twins.cli.command import OK, SCENARIO, WRONG_INPUT, Parser
from canopen_twins.cli.scenario_file import load
from canopen_twins.device.device import Device
from canopen_twins.device.settings import about
from canopen_twins.devices.eds import described
from canopen_twins.errors import UserError
from canopen_twins.files.document import LARGEST_FILE, Item, understand
from canopen_twins.files.whole import read_plain


def add_check(parser: Parser) -> None:
    """check."""
    text = f"a scenario ({SCENARIO}), a bench or device file, one that a setting names, or an EDS"
    parser.add_argument("files", nargs="+", metavar="FILE", help=text)
    parser.set_defaults(command=check)


def check(options: argparse.Namespace) -> int:
    """Say of every file whether it can be played, run or made a twin of; 2 if one cannot."""
    wrong = False
    for name in options.files:
        try:
            remarks = _remarks(name)
        except UserError as error:
            print(error, file=sys.stderr)
            wrong = True
            continue
        for line in remarks:
            print(line)
        print(f"{name}: ok{f', with {_counted(remarks)}' if remarks else ''}")
    return WRONG_INPUT if wrong else OK


def _remarks(name: str) -> Sequence[str]:
    """What is unusual in a file of which there can be a twin; none of other files.

    Raises:
        UserError: the file is of no use.
    """
    path = Path(name)
    if devices.tells_of_device(name):
        kind, eds = _described(path)
        Bench(kind)  # it boots
        return [remark.told(eds) for remark in described(eds).remarks]
    if path.is_dir():
        raise UserError(f"{name} is a directory: name the files in it, such as {path / '*.yaml'}")
    if owner := _owner(path):
        device, setting = owner
        devices.create(device, **{setting: name})
    elif path.exists() and understand(path, _is_bench):
        rules.load_bench(path)
    elif path.exists() and understand(path, lambda file: "contract" in file.pairs):
        from canopen_twins.hunt.grid import read_grid  # noqa: PLC0415 - which brings pydantic

        read_grid(path)
    else:
        load(name)
    return ()


def _owner(path: Path) -> tuple[str, str] | None:
    """The device and its setting that a file is for, by what it says; None if for none."""
    if not path.is_file():
        return None
    text = read_plain(path, LARGEST_FILE).decode("utf-8", "replace")
    for device in devices.names():
        for entry in fields(devices.find(device).settings):
            pattern = about(entry).file
            if pattern and re.search(pattern, text, re.MULTILINE):
                return device, entry.name
    return None


def _described(path: Path) -> tuple[type[Device], Path]:
    """The device of a file, and the EDS that it has or is."""
    if path.suffix.lower() not in devices.YAML:
        return described(path), path
    # pydantic, which a run without a scenario starts without
    from canopen_twins.devices.eds import compile as device_files  # noqa: PLC0415

    kind = device_files.described(path)
    return kind, Path(relpath(kind.eds))


def _is_bench(file: Item) -> bool:
    """Whether all that it says is what bench files say, which have no steps."""
    return "nodes" in file.pairs and "steps" not in file.pairs


def _counted(remarks: Sequence[str]) -> str:
    return "1 remark" if len(remarks) == 1 else f"{len(remarks)} remarks"


def add_schema(parser: Parser) -> None:
    """schema."""
    parser.add_argument(
        "file", nargs="?", choices=("scenario", "bench", "device", "campaign"), default="scenario"
    )
    parser.set_defaults(command=schema)


def schema(options: argparse.Namespace) -> int:
    """Print the JSON Schema of the files that users write, for their editors."""
    # pydantic, which a run without a scenario starts without
    from canopen_twins.devices.eds.device_file import DeviceFile  # noqa: PLC0415
    from canopen_twins.files.table import Table, json_schema  # noqa: PLC0415
    from canopen_twins.hunt.grid import CampaignFile  # noqa: PLC0415
    from canopen_twins.scenario.schema import BenchFile, ScenarioFile  # noqa: PLC0415

    tables: dict[str, type[Table]] = {
        "scenario": ScenarioFile,
        "bench": BenchFile,
        "device": DeviceFile,
        "campaign": CampaignFile,
    }
    print(json.dumps(json_schema(tables[options.file]), indent=2))
    return OK
