"""What somebody may have meant who wrote an unknown word."""

from collections.abc import Iterable
from difflib import get_close_matches


def did_you_mean(word: object, words: Iterable[str]) -> str:
    """The tail of an error message; empty when no word is near."""
    near = get_close_matches(str(word), list(words), n=1)
    return f", did you mean {near[0]!r}?" if near else ""
