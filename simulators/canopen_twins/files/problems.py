"""What is wrong with a file: everything at once, a line each, with its place."""

from collections.abc import Collection, Iterator
from contextlib import contextmanager
from typing import Protocol

from yaml import Mark

from canopen_twins.errors import UserError


class Placed(Protocol):
    """What has a place in a file."""

    @property
    def mark(self) -> Mark:
        """Where it begins."""


class DocumentError(UserError):
    """Everything that is wrong with a file: `lines`, each "file:line:column: what"."""

    def __init__(self, lines: Collection[str]) -> None:
        super().__init__("\n".join(lines))
        self.lines = tuple(lines)


class Mistake(UserError):  # noqa: N818 - of the user's, not of ours
    """Something wrong at a place of the file."""

    def __init__(self, mark: Mark, text: str) -> None:
        super().__init__(text)
        self.mark = mark


class Noted(UserError):  # noqa: N818 - likewise
    """What is wrong has been noted as a problem already; there is nothing to go on with."""


class Problems:
    """What has been found wrong with a file so far."""

    def __init__(self, file: str) -> None:
        self.file = file
        self._found: set[tuple[int, int, str]] = set()

    @property
    def none(self) -> bool:
        """Whether nothing has been found."""
        return not self._found

    def add(self, mark: Mark, text: str) -> None:
        """Note something wrong at a place."""
        self._found.add((mark.line + 1, mark.column + 1, text))

    @contextmanager
    def at(self, place: Placed) -> Iterator[None]:
        """Note what is wrong inside and go on behind; what knows no place is blamed on this one."""
        try:
            yield
        except Noted:
            pass
        except Mistake as mistake:
            self.add(mistake.mark, str(mistake))
        except UserError as refusal:
            self.add(place.mark, str(refusal))

    def settle(self) -> None:
        """Raises `DocumentError` if anything has been found."""
        if self._found:
            places = sorted(self._found)
            raise DocumentError([f"{self.file}:{line}:{col}: {text}" for line, col, text in places])
