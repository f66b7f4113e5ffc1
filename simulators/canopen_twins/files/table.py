"""Tables of a file as pydantic models: each value is read once, and the same as JSON Schema."""

import ast
import inspect
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from textwrap import dedent
from typing import Annotated, Any, ClassVar, Self, TypeVar

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    GetJsonSchemaHandler,
    PrivateAttr,
    ValidationError,
    WrapValidator,
    model_validator,
)
from pydantic.functional_validators import ModelWrapValidatorHandler
from pydantic.json_schema import GenerateJsonSchema, JsonSchemaValue
from pydantic_core import CoreSchema, ErrorDetails, core_schema

from canopen_twins.errors import UserError, unknown
from canopen_twins.files.document import Item, Meaning, Reported, understand
from canopen_twins.files.yaml_nodes import GLUED


@dataclass(frozen=True)
class Rule:
    """What the keys of a table have to do with each other."""

    check: Callable[[Item, Collection[str]], None]
    """Raises `UserError` for a table that breaks it; takes the keys there could be, too."""
    schema: Mapping[str, Any]
    """The same as JSON Schema."""


def one_of(what: str, keys: Collection[str], table: str = "a step", alone: str = "") -> Rule:
    """Exactly one of several keys; `what` they are for: "to do". Beside `alone` none will do."""

    def check(item: Item, known: Collection[str]) -> None:
        chosen = [key for key in keys if key in item.pairs]
        if len(chosen) == 1 or (not chosen and alone in item.pairs):
            return
        if not chosen and not item.pairs.keys() <= set(known):
            raise Reported  # the unknown key may be meant to be the one
        told = f"{' and '.join(chosen)} at once" if chosen else f"nothing {what}"
        raise item.wrong(f"{told}: {table} has one of {', '.join(keys)}")

    none = [{"required": [alone], "not": {"anyOf": _each_required(keys)}}] if alone else []
    return Rule(check, {"oneOf": [*_each_required(keys), *none]})


def some_of(keys: Collection[str], otherwise: str) -> Rule:
    """At least one of several keys; what is missing is said in its own words."""

    def check(item: Item, known: Collection[str]) -> None:
        if not item.pairs.keys() & set(keys):
            raise Reported if not item.pairs.keys() <= set(known) else item.wrong(otherwise)

    return Rule(check, {"anyOf": _each_required(keys)})


def beside(key: str, others: Collection[str]) -> Rule:
    """A key that stands only where one of several others does."""

    def check(item: Item, _: Collection[str]) -> None:
        if key in item.pairs and not item.pairs.keys() & set(others):
            names = " or ".join(map(repr, others))
            raise item.pairs[key].value.wrong(f"{key!r} stands beside {names} only")

    return Rule(check, {"if": {"required": [key]}, "then": {"anyOf": _each_required(others)}})


def apart(keys: Collection[str]) -> Rule:
    """Keys of which at most one can be there."""

    def check(item: Item, _: Collection[str]) -> None:
        if len(chosen := [key for key in keys if key in item.pairs]) > 1:
            raise item.pairs[chosen[1]].key.wrong(f"{' and '.join(chosen)} at once: leave one out")

    return Rule(check, {"not": {"required": [*keys]}})


def shapes(sets: Collection[str], otherwise: str) -> Rule:
    """Nothing but one of several sets of keys, each told as words."""
    allowed = [words.split() for words in sets]

    def check(item: Item, known: Collection[str]) -> None:
        if not item.pairs.keys() <= set(known):
            raise Reported
        if item.pairs.keys() not in [set(keys) for keys in allowed]:
            raise item.wrong(otherwise)

    schemas = [{"required": keys, "maxProperties": len(keys)} for keys in allowed]
    return Rule(check, {"oneOf": schemas})


def _each_required(keys: Iterable[str]) -> list[dict[str, Any]]:
    return [{"required": [key]} for key in keys]


@dataclass(frozen=True, eq=False)
class Leaf:
    """One value: what it means, and what it is as JSON Schema."""

    mean: Callable[[Item], object]
    """Raises `UserError` if it is not what is wanted."""
    schema: Mapping[str, Any]

    def __get_pydantic_core_schema__(self, *_: Any) -> CoreSchema:
        return core_schema.no_info_plain_validator_function(self.mean)

    def __get_pydantic_json_schema__(self, *_: Any) -> JsonSchemaValue:
        return dict(self.schema)


class Table(BaseModel):
    """Keys and their values; the docstring below a field is what editors say of it."""

    model_config = ConfigDict(extra="forbid", frozen=True)
    rules: ClassVar[tuple[Rule, ...]] = ()
    _place: Item = PrivateAttr()

    @property
    def place(self) -> Item:
        """Where it stands."""
        return self._place

    def item_of(self, key: str) -> Item:
        """What stands behind a key, as it stands there."""
        return self._place.pairs[key].value

    @model_validator(mode="wrap")
    @classmethod
    def _read(cls, item: Item, handler: ModelWrapValidatorHandler[Self]) -> Self:
        known = [field.alias or name for name, field in cls.model_fields.items()]
        values = {key: pair.value for key, pair in item.pairs.items()}
        for rule in cls.rules:
            try:
                rule.check(item, known)
            except UserError as refusal:
                item.problems.add(refusal, item.mark)
        try:
            table = handler(values)
        except ValidationError as failure:
            wrong = _report(item, failure, known)
            try:  # the rest may have problems of its own where it is used
                table = handler({key: values[key] for key in values if key not in wrong})
            except ValidationError:
                raise Reported from None
        table._place = item  # noqa: SLF001 - our own
        return table

    @classmethod
    def __get_pydantic_json_schema__(
        cls, core: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        schema = super().__get_pydantic_json_schema__(core, handler)
        table = handler.resolve_ref_schema(schema)
        for name, words in _docstrings(cls):
            table["properties"][cls.model_fields[name].alias or name]["description"] = words
        if cls.rules:
            table["allOf"] = [rule.schema for rule in cls.rules]
        return schema


def _docstrings(table: type[Table]) -> Iterator[tuple[str, str]]:
    """The fields of a table with what stands below them.

    pydantic does this too, but whenever it makes a model: every file that is read would wait.
    """
    for kind in reversed(table.__mro__[: table.__mro__.index(Table)]):
        [told] = ast.parse(dedent(inspect.getsource(kind))).body
        assert isinstance(told, ast.ClassDef)
        for entry, below in pairwise(told.body):
            match entry, below:
                case (
                    ast.AnnAssign(target=ast.Name(id=name)),
                    ast.Expr(value=ast.Constant(value=str(words))),
                ) if name in table.model_fields:
                    yield name, inspect.cleandoc(words)


def _report(item: Item, failure: ValidationError, known: Collection[str] = ()) -> set[object]:
    """Make problems of what is wrong with a value; returns the keys behind which it is.

    Where it is a table, `known` are its keys.
    """
    wrong: set[object] = set()
    for error in failure.errors(include_url=False, include_input=False):
        key, *_ = error["loc"] or (None,)
        place = item
        if key is not None and (pair := item.pairs.get(str(key))):
            place = pair.place(known)
        slip = _slip(item, str(key), known) if error["type"] == "extra_forbidden" else None
        item.problems.add(slip or REFUSALS[error["type"]](error, known), place.mark)
        wrong.add(key)
    return wrong


def _slip(item: Item, key: str, known: Collection[str]) -> UserError | None:
    """What is wrong with an unknown key that is one by a comma or by a space that is missing."""
    if (glued := GLUED.fullmatch(key)) and glued[1] in known:
        return UserError(f"unknown key {key!r}: a space is missing, {glued[1]}: {glued[2]}")
    keys = [*item.pairs]
    place = keys.index(key)
    before = item.pairs[keys[place - 1]].value if place else None
    if not key.isdecimal() or before is None or not before.is_decimal:
        return None
    meant = f"write {before.text}.{key} with a point"
    return UserError(f"unknown key {key!r}: a comma ends the value before it, {meant}")


REFUSALS: Mapping[str, Callable[[ErrorDetails, Collection[str]], UserError]] = {
    "value_error": lambda error, _: error["ctx"]["error"],
    "extra_forbidden": lambda error, known: unknown("key", error["loc"][0], known),
    "missing": lambda error, _: UserError(f"{error['loc'][0]!r} is missing"),
    "too_short": lambda *_: UserError("empty; at least one key with a value is wanted here"),
    "too_long": lambda error, _: UserError(f"more than {error['ctx']['max_length']} of them"),
}
"""What we say for what pydantic says."""


Anything = TypeVar("Anything")
AnyTable = TypeVar("AnyTable", bound=Table)


def _if_right(item: Item, validate: Callable[[Item], Anything]) -> Anything | None:
    try:
        return validate(item)
    except ValidationError as failure:
        _report(item, failure)
        return None


IfRight = Annotated[Anything | None, WrapValidator(_if_right)]
"""One of many: what is wrong with it becomes a problem, and None is in its place."""

Listed = Annotated[list[Anything], BeforeValidator(lambda item: item.items)]
"""Values after dashes."""


def understand_table(
    path: Path,
    kind: type[AnyTable],
    mean: Callable[[AnyTable], Meaning],
    text: str | None = None,
) -> Meaning:
    """What a file means that is such a table; takes and raises as `understand` does."""

    def meaning(item: Item) -> Meaning:
        if (table := _if_right(item, kind.model_validate)) is None:
            raise Reported
        return mean(table)

    return understand(path, meaning, text)


class _Generate(GenerateJsonSchema):
    """A key that may be left out has no value instead: `null` would be one."""

    def nullable_schema(self, schema: Any) -> JsonSchemaValue:
        return self.generate_inner(schema["schema"])

    default_schema = nullable_schema

    def field_title_should_be_set(self, schema: Any) -> bool:
        return False


def json_schema(table: type[Table]) -> dict[str, Any]:
    """The JSON Schema (draft 2020-12) of files that are such a table."""
    return {
        "$schema": _Generate.schema_dialect,
        **table.model_json_schema(schema_generator=_Generate),
    }
