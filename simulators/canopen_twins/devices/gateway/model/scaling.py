"""Internal values of the governor: what a measurement looks like in 16 bits (7.1.2.2, A-18)."""

from collections.abc import Iterable, Mapping
from typing import NamedTuple

from canopen_twins.devices.gateway.model.parameters import Catalogue, Parameter, Unit

SIGNED = (-0x8000, 0x7FFF)
UNSIGNED = (0, 0xFFFF)


class Scale(NamedTuple):
    """So many counts for the full scale, in the unit of the parameter."""

    full_scale: float
    counts: int


class Count(NamedTuple):
    """How one parameter is counted: its scale, and what fits."""

    full_scale: float
    counts: int
    low: int
    high: int

    def of(self, value: float) -> int:
        """The 16 bits a value is sent as, 0..FFFFh; what does not fit is cut off."""
        internal = round(value / self.full_scale * self.counts)
        return min(max(self.low, internal), self.high) & 0xFFFF


class Scaling:
    """Converts between what DcDesk shows and what TPDOs and RPDOs carry.

    A parameter without a scale of its own is counted in steps of its resolution.
    """

    def __init__(self, catalogue: Catalogue, scales: Mapping[int, Scale]) -> None:
        self._parameters = catalogue.of(Unit.GOVERNOR)
        self._scales = scales

    def analogue(self, number: int) -> Parameter | None:
        """The parameter with this number, if it can be sent in an analogue TPDO (4.1.2)."""
        parameter = self._parameters.get(number)
        return parameter if parameter is not None and parameter.analogue else None

    def count(self, number: int) -> Count:
        """How the parameter with this number is sent."""
        limits = SIGNED if self._parameters[number].signed else UNSIGNED
        return Count(*self._scale(number), *limits)

    def external(self, number: int, internal: int) -> float:
        """The value that the 16 unsigned bits of a CANopen sensor stand for."""
        scale = self._scale(number)
        return internal / scale.counts * scale.full_scale

    def _scale(self, number: int) -> Scale:
        return self._scales.get(number) or Scale(self._parameters[number].resolution, 1)


def scaling(catalogue: Catalogue, rows: Iterable[Mapping[str, str]]) -> Scaling:
    """The scaling of a table, one measurement a row.

    Columns: number, full_scale, unit (for the reader), counts.

    Raises:
        ValueError: a row that cannot be read, or that no 16 bits can follow.
    """
    scales: dict[int, Scale] = {}
    for line, row in enumerate(rows, start=2):
        try:
            number = int(row["number"])
            if number in scales:
                raise ValueError(f"{number} is there twice")
            scales[number] = _scale(catalogue, number, row)
        except KeyError as column:
            raise ValueError(f"line {line}: there is no column {column}") from None
        except ValueError as reason:
            raise ValueError(f"line {line}: {reason}") from None
    return Scaling(catalogue, scales)


def _scale(catalogue: Catalogue, number: int, row: Mapping[str, str]) -> Scale:
    parameter = catalogue.find(Unit.GOVERNOR, number)
    scale = Scale(float(row["full_scale"]), int(row["counts"]))
    if not parameter.analogue:
        raise ValueError(f"{parameter.title}: a single bit has no scale")
    if not scale.full_scale > 0:
        raise ValueError(f"{parameter.title}: full scale {scale.full_scale:g} is not above 0")
    high = (SIGNED if parameter.signed else UNSIGNED)[1]
    if not 0 < scale.counts <= high:
        raise ValueError(f"{parameter.title}: {scale.counts} counts are not in 1..{high}")
    return scale
