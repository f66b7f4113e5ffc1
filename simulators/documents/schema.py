"""Tables of a file as JSON Schema, for editors."""

from typing import Any

from pydantic.json_schema import GenerateJsonSchema, JsonSchemaValue
from pydantic_core import core_schema

from simulators.documents.table import Table


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
