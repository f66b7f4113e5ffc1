"""The catalogue of messages as a file lists it, such as od/charger_messages.yaml."""

from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

from simulators.devices.charger.model.catalogue import Catalogue, Kind, Message
from simulators.documents.document import Item, understand
from simulators.documents.keys import values
from simulators.errors import UserError

FORMAT = "charger_messages/1"


def read_catalogue(path: Path) -> Catalogue:
    """The messages of a file.

    Raises:
        DocumentError: with a line for everything that is wrong, each with its place.
    """
    return understand(path, _catalogue)


def _catalogue(file: Item) -> Catalogue:
    told = values(file, KEYS)
    return Catalogue([*told["errors"], *told["warnings"]])


def _format(item: Item) -> str:
    return item.one_of("format", [FORMAT])


def _key(item: Item) -> str:
    if not item.text:
        raise item.wrong("empty; a key is a word")
    return item.text


def _messages(rows: Item, kind: Kind) -> list[Message]:
    messages: list[Message] = []
    for row in rows.items:
        with row.problems.at(row):
            told = values(row, ROW, optional=("trips", "when"))
            told.pop("when", None)  # for the reader
            try:
                messages = list(Catalogue([*messages, Message(kind, **told)]))
            except ValueError as refusal:
                raise UserError(str(refusal)) from refusal
    return messages


KEYS: Mapping[str, Callable[[Item], Any]] = {
    "format": _format,
    "assumed": lambda item: item.truth,
    "errors": partial(_messages, kind=Kind.ERROR),
    "warnings": partial(_messages, kind=Kind.WARNING),
}
ROW: Mapping[str, Callable[[Item], Any]] = {
    "number": lambda item: item.whole,
    "key": _key,
    "emcy": lambda item: item.whole,
    "register": lambda item: item.whole,
    "trips": lambda item: item.truth,
    "when": lambda item: item.text,
}
