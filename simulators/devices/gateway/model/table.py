"""Reads the rows of the parameter table; what is wrong in one is told in one line."""

from collections.abc import Iterable, Mapping

from simulators.devices.gateway.model.parameters import Catalogue, Parameter, Unit


def catalogue(rows: Iterable[Mapping[str, str]]) -> Catalogue:
    """The parameters of a table, one a row.

    Columns: control_unit, number, name, range, resolution, level, unit, default, source.
    A range is `low..high`, or the allowed values with `|` between them; 0x marks hexadecimal.

    Raises:
        ValueError: a row that cannot be read, or a number that is there twice.
    """
    return Catalogue(_parameter(line, row) for line, row in enumerate(rows, start=2))


def _parameter(line: int, row: Mapping[str, str]) -> Parameter:
    try:
        low, high, choices = _range(row["range"])
        parameter = Parameter(
            control_unit=Unit(row["control_unit"]),
            number=int(row["number"]),
            name=row["name"],
            low=low,
            high=high,
            choices=choices,
            resolution=float(row["resolution"]),
            level=int(row["level"]),
            unit=row["unit"],
            default=_number(row["default"]),
            source=row["source"],
        )
        parameter.checked(parameter.default)
    except KeyError as column:
        raise ValueError(f"line {line}: there is no column {column}") from None
    except (ValueError, ZeroDivisionError) as reason:
        raise ValueError(f"line {line}: {reason}") from None
    return parameter


def _range(text: str) -> tuple[float, float, tuple[float, ...]]:
    if "|" in text:
        choices = tuple(_number(choice) for choice in text.split("|"))
        return min(choices), max(choices), choices
    low, _, high = text.partition("..")
    return _number(low), _number(high), ()


def _number(text: str) -> float:
    return float(text) if "." in text else int(text, 0)
