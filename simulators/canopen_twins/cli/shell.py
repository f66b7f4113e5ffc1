"""completion and man: what a shell and its manual are told, made from the parsers themselves."""

import argparse
from collections.abc import Callable, Iterable, Iterator, Mapping
from importlib import import_module
from typing import Any

from canopen_twins import devices
from canopen_twins.cli.command import OK, Parser
from canopen_twins.errors import UserError
from canopen_twins.files.shipped import scenarios

SHELLS = ("bash", "zsh", "fish")
WORDS: Mapping[str, Callable[[], Iterable[str]]] = {
    "DEVICE": devices.names,
    "SCENARIO": scenarios,
}
"""By what stands for it in the help: the words beside which a file will do, too."""
FUNCTIONS: Mapping[str, str] = {
    "bash": """{name}() {{ compgen -W "{words}" -- "$1"; compgen -f -- "$1"; }}""",
    "zsh": """{name}() {{ _alternative "words:{place}:({words})" "files:file:_files" }}""",
    "fish": """function {name}
  string split " " "{words}"
  __fish_complete_path (commandline -ct)
end""",
}
CALLS: Mapping[str, str] = {"bash": "{name}", "zsh": "{name}", "fish": "({name})"}


def add_completion(parser: Parser) -> None:
    """completion."""
    parser.add_argument("shell", choices=SHELLS, help="for which shell")
    parser.set_defaults(command=completion)


def completion(options: argparse.Namespace) -> int:
    """Print the script that completes commands, options, devices, scenarios and files."""
    shtab = _extra("shtab")
    top = _everything()
    for action in _arguments(top):
        if action.choices is None and action.nargs != 0:
            action.complete = _complete(shtab, action)  # type: ignore[attr-defined]
    print(shtab.complete(top, options.shell))
    return OK


def _complete(shtab: Any, action: argparse.Action) -> Mapping[str, object]:
    """How each shell finds what may stand there, as shtab takes it."""
    place = action.metavar if isinstance(action.metavar, str) else ""
    if place not in WORDS:
        files: Mapping[str, object] = shtab.DIRECTORY if place == "DIR" else shtab.FILE
        return files
    told = {
        "name": f"_canopen_twin_{place.lower()}",
        "place": place.lower(),
        "words": " ".join(WORDS[place]()),
    }
    preamble = {shell: text.format(**told) for shell, text in FUNCTIONS.items()}
    return {**{shell: call.format(**told) for shell, call in CALLS.items()}, "preamble": preamble}


def add_man(parser: Parser) -> None:
    """man."""
    parser.set_defaults(command=man)


def man(options: argparse.Namespace) -> int:
    """Print the page of the manual, in roff."""
    page = _extra("argparse_manpage.manpage").Manpage(_everything())
    page.manual, page.description = "canopen-twins", "digital twins of CANopen slaves"
    print(page, end="")
    return OK


def _extra(module: str) -> Any:
    try:
        return import_module(module)
    except ModuleNotFoundError as missing:
        raise UserError("this needs the extra: pip install 'canopen-twins[shell]'") from missing


def _everything() -> argparse.ArgumentParser:
    """The parser with all its commands filled in."""
    top: argparse.ArgumentParser = import_module("canopen_twins.cli").parser()  # which knows us
    for command in _commands(top):
        command.fill()
    return top


def _commands(top: argparse.ArgumentParser) -> Iterator[Parser]:
    for action in _actions(top):
        if isinstance(action.choices, dict):
            yield from action.choices.values()


def _arguments(top: argparse.ArgumentParser) -> Iterator[argparse.Action]:
    for command in _commands(top):
        yield from _actions(command)


def _actions(parser: argparse.ArgumentParser) -> list[argparse.Action]:
    """All that was added; argparse has no other way to ask."""
    found: list[argparse.Action] = vars(parser)["_actions"]
    return found
