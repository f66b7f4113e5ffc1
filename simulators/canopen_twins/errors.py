"""What is wrong with what a user gave us, in one line that also says what would be right."""

from collections.abc import Iterable, Mapping, Sequence

LONGEST_LIST = 24  # names in one line; a dictionary has hundreds


class UserError(ValueError):
    """Wrong input: its message is one line for the user; anything else that is raised is a bug."""


def unknown(
    what: str,
    word: object,
    known: Iterable[str],
    others: Mapping[str, Sequence[str]] | None = None,
) -> UserError:
    """An error for a word that is none of the known ones, with the nearest of them.

    Args:
        what: What the word is of, such as "fault".
        word: What the user has said.
        known: What there is.
        others: What else people say, and which of the known words they mean by it, best first.
    """
    from difflib import get_close_matches  # noqa: PLC0415 - only who is wrong needs it

    names = sorted(known)
    meant = {name: name for name in names}
    for other, candidates in (others or {}).items():
        if name := next((name for name in candidates if name in names), None):
            meant[other] = name
    said = str(word).strip().lower().replace("-", "_").replace(" ", "_")
    near = [said] if said in meant else []
    if near := near or get_close_matches(str(word), meant, n=1):
        hint = f"did you mean {meant[near[0]]!r}?"
    elif len(names) > LONGEST_LIST:
        hint = f"there are {len(names)}, none of them near"
    else:
        hint = f"there is {', '.join(names) or 'none'}"
    return UserError(f"unknown {what} {str(word)!r}: {hint}")
