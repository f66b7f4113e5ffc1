"""Tables of a file as pydantic models: structure and JSON Schema are theirs, places are ours.

A field holds an `Item` that has been asked whether it is what is wanted, or other tables. What is
wrong is noted as a problem with its place, and a table is read again without it: the rest is looked
at all the same.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, ClassVar, Self, TypeVar

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
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema, core_schema

from simulators.documents.document import Item, Meaning, understand
from simulators.documents.failures import note
from simulators.documents.problems import Noted
from simulators.documents.rules import Rule


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
