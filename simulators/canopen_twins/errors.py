"""What is wrong with what a user gave us, in one line that also says what would be right."""

from collections.abc import Iterable

LONGEST_LIST = 24  # names in one line; a dictionary has hundreds


class UserError(ValueError):
    """Wrong input: its message is one line for the user; anything else that is raised is a bug."""


def unknown(what: str, word: object, known: Iterable[str]) -> UserError:
    """An error for a word that is none of the known ones, with the nearest of them."""
    from difflib import get_close_matches  # noqa: PLC0415 - only who is wrong needs it

    names = sorted(known)
    if near := get_close_matches(str(word), names, n=1):
        hint = f"did you mean {near[0]!r}?"
    elif len(names) > LONGEST_LIST:
        hint = f"there are {len(names)}, none of them near"
    else:
        hint = f"there is {', '.join(names) or 'none'}"
    return UserError(f"unknown {what} {str(word)!r}: {hint}")
