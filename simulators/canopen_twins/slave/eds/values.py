"""Values as EDS files write them, by the data type of their object (CiA 306, 4.3 and 4.6.3).

The standard knows decimal, 0x, octal with a leading 0, and `$NODEID`. Tools also write signed
values as unsigned bit patterns, `1,5`, the bits of a float, and words. What can only mean one
thing is taken; where a reading is a guess, `Value.doubt` says which.
"""

import re
import struct
from collections.abc import Callable, Collection
from functools import lru_cache
from typing import NamedTuple

from canopen.objectdictionary import ODVariable
from canopen.objectdictionary.datatypes import (
    BOOLEAN,
    DOMAIN,
    FLOAT_TYPES,
    OCTET_STRING,
    REAL32,
    SIGNED_TYPES,
    UNICODE_STRING,
    UNSIGNED_TYPES,
    VISIBLE_STRING,
)

from canopen_twins.slave.object import TIME_SIZE, TIMES

LONGEST_DAY = 1 << 28
BYTES = (OCTET_STRING, DOMAIN)
TEXTS = (VISIBLE_STRING, UNICODE_STRING)
NODE_ID = re.compile(r"\$NODE_?ID", re.IGNORECASE)
TERM = re.compile(r"([+-]?)\s*([^\s+-]+)\s*")
WHOLE = re.compile(r"(?P<sign>[+-]?)(?:0[xX](?P<hex>[0-9A-Fa-f]+)|(?P<digits>[0-9]+))[uUlL]*")
HEX_BEHIND = re.compile(r"[0-9][0-9A-Fa-f]*[hH]")
DECIMAL = re.compile(r"[+-]?(?:[0-9]+[.,][0-9]*|[.,][0-9]+|[0-9]+)(?:[eE][+-]?[0-9]{1,3})?")
WORDS = {
    **dict.fromkeys(("true", "yes", "on", "enabled"), 1),
    **dict.fromkeys(("false", "no", "off", "none", "disabled"), 0),
}
MOST_KEPT = 1024  # numbers: most entries of a file have the same types, limits and defaults
MOST_DIGITS = 40  # of a number: the largest there is has 20


class Value(NamedTuple):
    """A value, and in which reading of its text."""

    value: int | float | str | bytes
    relative: bool = False
    """Whether the node id has to be added."""
    doubt: str = ""
    """What somebody may have meant otherwise; empty if nothing."""


def uncommented(text: str) -> str:
    """A number without the comment that some tools put behind it."""
    if ";" in text or "#" in text:
        text = re.split("[;#]", text, maxsplit=1)[0]
    return text.strip()


def uncommented_words(text: str) -> str:
    """A name or a text without a comment behind it; without a blank a semicolon belongs to it."""
    if ";" in text:
        text = re.split(r"\s;", text, maxsplit=1)[0]
    return text.strip()


@lru_cache(MOST_KEPT)
def count(text: str) -> Value:
    """A number that is no value of an object: a leading zero there is mostly padding, not octal.

    Raises:
        ValueError: it is none.
    """
    number = uncommented(text).strip("\"'")
    if (word := WORDS.get(number.lower())) is not None:
        return Value(word, doubt=f"{text!r} is taken for {word}")
    if len(number) > 1 and number.isdigit() and number.startswith("0"):
        value = int(number)
        octal = set(number) <= set("01234567") and int(number, 8) != value
        return Value(value, doubt=f"{text!r} is taken for {value}, not octal" if octal else "")
    return _whole(number)


def value(text: str, data_type: int) -> Value:
    """The value of an object.

    Raises:
        ValueError: the text is no value of the type, with the reason.
    """
    if data_type in TEXTS:
        return _text(text, data_type)
    read = next((read for types, read in READERS if data_type in types), _raw)
    return read(uncommented(text), data_type)


@lru_cache(MOST_KEPT)
def _integer(text: str, data_type: int) -> Value:
    found = _formula(text) if NODE_ID.search(text) else _whole(text, octal=True)
    bits = ODVariable.STRUCT_TYPES[data_type].size * 8
    number = int(found.value)
    if found.relative and -(1 << bits) < number < 1 << bits:
        return found
    lowest, highest = (-(1 << bits - 1), (1 << bits - 1) - 1)
    if data_type in UNSIGNED_TYPES:
        if lowest <= number < 0:
            doubt = f"{text} is taken for the bits of 0x{number + (1 << bits):X}"
            return found._replace(value=number + (1 << bits), doubt=doubt)
        lowest, highest = 0, (1 << bits) - 1
    elif highest < number < 1 << bits:  # its bits, as most tools write it
        return found._replace(value=number - (1 << bits))
    if not lowest <= number <= highest:
        raise ValueError(f"{text} does not fit {bits} bits")
    return found


def _whole(text: str, octal: bool = False) -> Value:
    if len(text) > MOST_DIGITS:
        raise ValueError("no number has so many digits")
    if match := WHOLE.fullmatch(text):
        return _by_notation(text, match, octal)
    if HEX_BEHIND.fullmatch(text):
        return Value(int(text[:-1], 16), doubt=f"{text} is taken for 0x{text[:-1]}")
    if DECIMAL.fullmatch(text):
        number = float(text.replace(",", "."))
        if abs(number) >= 1 << 64:
            raise ValueError(f"{text} is too large")
        lost = number != int(number)
        return Value(int(number), doubt=f"{text} is taken for {int(number)}" if lost else "")
    raise ValueError(f"{text!r} is no number")


def _by_notation(text: str, match: re.Match[str], octal: bool) -> Value:
    sign = -1 if match["sign"] == "-" else 1
    if match["hex"]:
        return Value(sign * int(match["hex"], 16))
    digits = match["digits"]
    if octal and len(digits) > 1 and digits.startswith("0"):
        if set(digits) <= set("01234567"):
            return Value(sign * int(digits, 8))
        return Value(sign * int(digits), doubt=f"{text} is no octal number: taken as decimal")
    return Value(sign * int(digits))


def _formula(text: str) -> Value:
    """`$NODEID+0x180`, from either side, in any case, with further terms."""
    total, node_ids, rest = 0, 0, text.strip()
    while rest:
        term = TERM.match(rest)
        if term is None or (len(rest) < len(text.strip()) and not term[1]):
            raise ValueError(f"{text!r} is no sum with $NODEID")
        if NODE_ID.fullmatch(term[2]):
            node_ids += -1 if term[1] == "-" else 1
        else:
            total += int(_whole(term[1] + term[2], octal=True).value)
        rest = rest[term.end() :]
    if node_ids != 1:
        raise ValueError(f"{text!r} does not add $NODEID once")
    return Value(total, relative=True)


def _real(text: str, data_type: int) -> Value:
    """Hexadecimal digits are the bits of the number; anything else is the number itself."""
    match = WHOLE.fullmatch(text)
    if match and match["hex"] and not match["sign"]:
        size, code = (4, "<f") if data_type == REAL32 else (8, "<d")
        bits = int(match["hex"], 16)
        if bits >= 1 << size * 8:
            raise ValueError(f"{text} does not fit {size * 8} bits")
        number: float = struct.unpack(code, bits.to_bytes(size, "little"))[0]
        return Value(number)
    if DECIMAL.fullmatch(text) or text.lower().lstrip("+-") in {"nan", "inf", "infinity"}:
        number = float(text.replace(",", "."))
        if data_type == REAL32:
            number = _single(number, text)
        return Value(number, doubt=f"{text} is taken for {number:g}" if "," in text else "")
    raise ValueError(f"{text!r} is no number")


def _single(number: float, text: str) -> float:
    try:
        struct.pack("<f", number)
    except OverflowError:
        raise ValueError(f"{text} does not fit 32 bits") from None
    return number


def _boolean(text: str, _: int) -> Value:
    word = WORDS.get(text.lower())
    number = _whole(text).value if word is None else word
    if number not in {0, 1}:
        return Value(True, doubt=f"{text} is taken for 1")
    return Value(bool(number))


def _text(text: str, data_type: int) -> Value:
    words = uncommented_words(text)
    if len(words) > 1 and words[0] == words[-1] and words[0] in "\"'":
        words = words[1:-1]
    if data_type == VISIBLE_STRING and not words.isascii():
        sent = words.encode("latin-1", "replace")
        return Value(sent, doubt=f"{words!r} is no ASCII: sent as Latin-1")
    return Value(words)


def _bytes(text: str, _: int) -> Value:
    digits = re.sub(r"0[xX]|[\s,]", "", text.strip("\"'"))
    try:
        return Value(bytes.fromhex(digits))
    except ValueError:
        raise ValueError(f"{text!r} is no row of bytes of two hex digits each") from None


def _time(text: str, _: int) -> Value:
    """Days and milliseconds, or the one number that both are on the wire."""
    parts = text.split()
    numbers = [int(_whole(part).value) for part in parts]
    if len(parts) == 2:
        days, milliseconds = numbers
        if not (0 <= days < 1 << 16 and 0 <= milliseconds < LONGEST_DAY):
            raise ValueError(f"{text!r} is not days and milliseconds of a day")
        return Value(struct.pack("<LH", milliseconds, days))
    if len(parts) != 1 or not 0 <= numbers[0] < 1 << 8 * TIME_SIZE:
        raise ValueError(f"{text!r} is neither days and milliseconds nor a number of 48 bits")
    return Value(numbers[0].to_bytes(TIME_SIZE, "little"))


def _raw(text: str, _: int) -> Value:
    """The bytes of a type that only its maker knows."""
    try:
        number = int(_whole(text).value)
    except ValueError:
        return _bytes(text, DOMAIN)
    if number < 0:
        raise ValueError(f"{text!r} is no row of bytes")
    return Value(number.to_bytes(max(1, (number.bit_length() + 7) // 8), "little"))


READERS: tuple[tuple[Collection[int], Callable[[str, int], Value]], ...] = (
    ((*SIGNED_TYPES, *UNSIGNED_TYPES), _integer),
    ((BOOLEAN,), _boolean),
    (FLOAT_TYPES, _real),
    (BYTES, _bytes),
    (TIMES, _time),
)
"""By data type; a type that is none of these is its maker's."""
