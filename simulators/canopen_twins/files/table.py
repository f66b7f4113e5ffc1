"""Rules about keys that stand together: each checks a table, and says the same as JSON Schema."""

from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, ClassVar, Protocol, Self, TypeVar

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    GetCoreSchemaHandler,
    GetJsonSchemaHandler,
    PrivateAttr,
    ValidationError,
    ValidatorFunctionWrapHandler,
    WrapValidator,
    model_validator,
)
from pydantic.functional_validators import ModelWrapValidatorHandler
from pydantic.json_schema import GenerateJsonSchema, JsonSchemaValue
from pydantic_core import CoreSchema, ErrorDetails, core_schema

from canopen_twins.errors import UserError, unknown
from canopen_twins.files.document import Item, Meaning, understand
from canopen_twins.files.problems import Noted


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


def note(item: Item, failure: ValidationError, known: Collection[str] = ()) -> set[object]:
    """Note as problems what is wrong with a value; the keys behind which it is.

    Where it is a table, `known` are its keys.
    """
    wrong: set[object] = set()
    for error in failure.errors(include_url=False, include_input=False):
        with item.problems.at(_place(item, error, known)):
            raise TOLD[error["type"]](error, known)
        wrong.update(error["loc"][:1])
    return wrong


def _place(item: Item, error: ErrorDetails, known: Collection[str]) -> Item:
    key, *_ = error["loc"] or (None,)
    if key is None or key not in item.pairs:
        return item
    return item.pairs[str(key)].place(known)


def _own(error: ErrorDetails, known: Collection[str]) -> UserError:
    refusal: UserError = error["ctx"]["error"]
    return refusal


TOLD: Mapping[str, Callable[[ErrorDetails, Collection[str]], UserError]] = {
    "value_error": _own,
    "extra_forbidden": lambda error, known: unknown("key", error["loc"][0], known),
    "missing": lambda error, _: UserError(f"{error['loc'][0]!r} is missing"),
    "too_short": lambda *_: UserError("empty; at least one key with a value is wanted here"),
    "too_long": lambda error, _: UserError(f"more than {error['ctx']['max_length']} of them"),
}


@dataclass(frozen=True, eq=False)
class Leaf:
    """A value of the file: what it is asked when it is read, and what it is as JSON Schema."""

    ask: Callable[[Item], object]
    """Raises `UserError` if it is not what is wanted."""
    schema: Mapping[str, Any]

    def _read(self, item: Item) -> Item:
        with item.blamed():
            self.ask(item)
        return item

    def __get_pydantic_core_schema__(self, _: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_plain_validator_function(self._read)

    def __get_pydantic_json_schema__(
        self, _: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        return dict(self.schema)


class Table(BaseModel):
    """Keys and their values; the docstring below a field is what editors say of it."""

    model_config = ConfigDict(extra="forbid", frozen=True, use_attribute_docstrings=True)
    rules: ClassVar[tuple[Rule, ...]] = ()
    _place: Item = PrivateAttr()

    @property
    def place(self) -> Item:
        """Where it stands."""
        return self._place

    @model_validator(mode="wrap")
    @classmethod
    def _read(cls, item: Item, handler: ModelWrapValidatorHandler[Self]) -> Self:
        known = [field.alias or name for name, field in cls.model_fields.items()]
        values = {key: pair.value for key, pair in item.pairs.items()}
        for rule in cls.rules:
            with item.problems.at(item):
                rule.check(item, known)
        try:
            table = handler(values)
        except ValidationError as failure:
            wrong = note(item, failure, known)
            table = _again(handler, {key: values[key] for key in values if key not in wrong})
        table._place = item  # noqa: SLF001 - our own
        return table

    @classmethod
    def __get_pydantic_json_schema__(
        cls, core: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        schema = super().__get_pydantic_json_schema__(core, handler)
        if cls.rules:
            handler.resolve_ref_schema(schema)["allOf"] = [rule.schema for rule in cls.rules]
        return schema


Anything = TypeVar("Anything")
AnyTable = TypeVar("AnyTable", bound=Table)


def understand_table(
    path: Path, kind: type[AnyTable], mean: Callable[[AnyTable], Meaning]
) -> Meaning:
    """What a file means that is such a table; raises as `understand` does."""

    def meaning(item: Item) -> Meaning:
        try:
            return mean(kind.model_validate(item))
        except ValidationError as failure:
            note(item, failure)
            raise Noted from None

    return understand(path, meaning)


def _if_right(item: Item, handler: ValidatorFunctionWrapHandler) -> Any:
    try:
        return handler(item)
    except ValidationError as failure:
        note(item, failure)
        return None


IfRight = Annotated[Anything | None, WrapValidator(_if_right)]
"""One of many: what is wrong with it is noted, and None is in its place."""

Listed = Annotated[list[Anything], BeforeValidator(lambda item: item.items)]
"""Values after dashes."""


def _again(handler: Callable[[dict[str, Item]], Any], values: dict[str, Item]) -> Any:
    try:
        return handler(values)
    except ValidationError:
        raise Noted from None


class _Generate(GenerateJsonSchema):
    """A key that may be left out has no value instead: `null` would be one."""

    def nullable_schema(self, schema: core_schema.NullableSchema) -> JsonSchemaValue:
        return self.generate_inner(schema["schema"])

    def default_schema(self, schema: core_schema.WithDefaultSchema) -> JsonSchemaValue:
        return self.generate_inner(schema["schema"])

    def field_title_should_be_set(self, schema: Any) -> bool:
        return False


def json_schema(table: type[Table]) -> dict[str, Any]:
    """The JSON Schema (draft 2020-12) of files that are such a table."""
    return {
        "$schema": _Generate.schema_dialect,
        **table.model_json_schema(schema_generator=_Generate),
    }
