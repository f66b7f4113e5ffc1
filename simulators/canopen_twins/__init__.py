"""Digital twins of CANopen slaves: the dictionaries and behaviour of real devices."""

from typing import TYPE_CHECKING, Any

from canopen_twins.errors import UserError

if TYPE_CHECKING:
    from canopen_twins.bench.bench import Bench


__all__ = ["Bench", "UserError"]


def __getattr__(name: str) -> Any:
    """Import `Bench` when it is asked for: pytest loads our plugin in runs that need none of it."""
    if name == "Bench":
        from canopen_twins.bench.bench import Bench  # noqa: PLC0415

        return Bench
    raise AttributeError(f"module 'canopen_twins' has no attribute {name!r}")
