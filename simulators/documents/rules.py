"""Rules about keys that stand together: each checks a table, and says the same as JSON Schema."""

from collections.abc import Collection, Iterable
from dataclasses import dataclass
from typing import Any, Protocol

from simulators.documents.document import Item
from simulators.documents.problems import Noted


class Rule(Protocol):
    """What the keys of a table have to do with each other."""

    def check(self, table: Item, known: Collection[str]) -> None:
        """Raises `UserError` for a table that breaks it; `known` are the keys there could be."""

    @property
    def schema(self) -> dict[str, Any]:
        """The rule as JSON Schema."""


@dataclass(frozen=True)
class OneOf:
    """Exactly one of several keys."""

    what: str
    """What the key is for: "nothing to do"."""
    keys: Collection[str]
    table: str = "a step"

    def check(self, table: Item, known: Collection[str]) -> None:
        """A key that is unknown may be meant to be the one."""
        chosen = [key for key in self.keys if key in table.pairs]
        if len(chosen) == 1:
            return
        if not chosen and not table.pairs.keys() <= set(known):
            raise Noted
        told = f"{' and '.join(chosen)} at once" if chosen else f"nothing {self.what}"
        raise table.wrong(f"{told}: {self.table} has one of {', '.join(self.keys)}")

    @property
    def schema(self) -> dict[str, Any]:
        """One of them is required, and no two."""
        return {"oneOf": _each_required(self.keys)}


@dataclass(frozen=True)
class SomeOf:
    """At least one of several keys; what is missing is said in its own words."""

    keys: Collection[str]
    otherwise: str

    def check(self, table: Item, known: Collection[str]) -> None:
        """Any of them will do."""
        if not table.pairs.keys() & set(self.keys):
            raise Noted if not table.pairs.keys() <= set(known) else table.wrong(self.otherwise)

    @property
    def schema(self) -> dict[str, Any]:
        """Any of them."""
        return {"anyOf": _each_required(self.keys)}


@dataclass(frozen=True)
class Beside:
    """A key that stands only where one of several others does."""

    key: str
    others: Collection[str]

    def check(self, table: Item, known: Collection[str]) -> None:
        """What is to blame is the key that is there."""
        if self.key in table.pairs and not table.pairs.keys() & set(self.others):
            others = " or ".join(map(repr, self.others))
            raise table.pairs[self.key].value.wrong(f"{self.key!r} stands beside {others} only")

    @property
    def schema(self) -> dict[str, Any]:
        """Where the one is, so is another."""
        return {"if": {"required": [self.key]}, "then": {"anyOf": _each_required(self.others)}}


@dataclass(frozen=True)
class Apart:
    """Keys of which at most one can be there."""

    keys: Collection[str]

    def check(self, table: Item, known: Collection[str]) -> None:
        """Two of them contradict each other."""
        if len(chosen := [key for key in self.keys if key in table.pairs]) > 1:
            raise table.pairs[chosen[1]].key.wrong(f"{' and '.join(chosen)} at once: leave one out")

    @property
    def schema(self) -> dict[str, Any]:
        """Not all of them."""
        return {"not": {"required": [*self.keys]}}


@dataclass(frozen=True)
class Shapes:
    """Nothing but one of several sets of keys, each told as words."""

    keys: Collection[str]
    otherwise: str

    def check(self, table: Item, known: Collection[str]) -> None:
        """A key that is unknown is told for itself."""
        if not table.pairs.keys() <= set(known):
            raise Noted
        if table.pairs.keys() not in [set(keys.split()) for keys in self.keys]:
            raise table.wrong(self.otherwise)

    @property
    def schema(self) -> dict[str, Any]:
        """All keys of one of them and no more."""
        sets = [keys.split() for keys in self.keys]
        return {"oneOf": [{"required": keys, "maxProperties": len(keys)} for keys in sets]}


def _each_required(keys: Iterable[str]) -> list[dict[str, Any]]:
    return [{"required": [key]} for key in keys]
