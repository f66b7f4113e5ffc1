"""events.jsonl of a record: what happened beside the frames, one JSON object a line."""

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple, TextIO

from canopen_twins.errors import UserError

LONGEST_LINE = 1 << 20  # characters
FOREVER = 1e9  # seconds; no run is longer
HEARD, STATE, END = "heard", "state", "end"

PHRASES = {
    HEARD: "heard {frame}",
    STATE: "{state}",
    END: "the run is over",
    "emcy": "{words}",
    "step": "step of line {line}: {what}",
    "inject": "fault {fault}({parameters}) injected",
    "clear": "fault {fault} cleared",
    "outcome": "{verdict} of line {line}: {what}: {seen}",
}


class EventLine(NamedTuple):
    """One line."""

    time: float
    """Seconds of the run."""
    kind: str
    node: str
    """Whom it is about; empty for the bus."""
    fields: Mapping[str, Any]

    def __str__(self) -> str:
        try:
            told = PHRASES[self.kind].format(**self._words)
        except KeyError:  # a record of tomorrow, or of somebody else
            told = f"{self.kind} {json.dumps(self.fields)}"
        return f"{self.time:12.6f}  {self.node or '-':10}  {told}"

    @property
    def _words(self) -> Mapping[str, object]:
        """The fields, parameters as one would write them down."""
        parameters = self.fields.get("parameters")
        if not isinstance(parameters, Mapping):
            return self.fields
        told = ", ".join(f"{key}={value}" for key, value in parameters.items())
        return {**self.fields, "parameters": told}


def write_event(file: TextIO, event: EventLine) -> None:
    """Add a line, which is the same for the same event."""
    time, kind, node, fields = event
    line = {**fields, "time": time, "kind": kind, "node": node}
    file.write(json.dumps(line, sort_keys=True, default=str) + "\n")


def read_events(path: Path) -> Iterator[EventLine]:
    """Every line of a file.

    Raises:
        UserError: the file cannot be read, or a line of it is none of ours.
    """
    try:
        with path.open(encoding="utf-8") as file:
            for number, line in enumerate(iter(lambda: file.readline(LONGEST_LINE), ""), 1):
                yield _event(f"{path}:{number}", line)
    except (OSError, UnicodeError) as failure:
        reason = getattr(failure, "strerror", None) or "no UTF-8"
        raise UserError(f"{path}: {reason}") from failure


def _event(where: str, line: str) -> EventLine:
    try:
        fields = json.loads(line)
        time, kind, node = fields.pop("time"), fields.pop("kind"), fields.pop("node")
        if not (isinstance(kind, str) and isinstance(node, str) and 0 <= time < FOREVER):
            raise TypeError
        return EventLine(time, kind, node, fields)
    except (ValueError, TypeError, AttributeError, KeyError, RecursionError):
        raise UserError(f"{where} is damaged: it is no event") from None
