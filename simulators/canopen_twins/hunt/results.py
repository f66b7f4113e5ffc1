"""The runs of a campaign that have been played, in one SQLite file: none is done twice."""

from __future__ import annotations

import json
import sqlite3
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

from canopen_twins.errors import UserError
from canopen_twins.files.whole import plain_file

TABLE = "CREATE TABLE IF NOT EXISTS runs (key TEXT PRIMARY KEY, told TEXT NOT NULL) WITHOUT ROWID"
DAMAGED = ".bad"


class Results(AbstractContextManager["Results"]):
    """What came of runs by their keys; each is kept at once, whole or not at all.

    Only one process writes. A key says all that a run depends on, so what others have left in the
    file may stay there.
    """

    def __init__(self, path: Path) -> None:
        """Raises `UserError` if the file cannot be opened; a damaged one is kept aside, with a line
        of `told`."""
        self.told = ""
        path = plain_file(path)
        try:
            self._open(path)
        except sqlite3.DatabaseError as damage:
            self._database.close()
            if isinstance(damage, sqlite3.OperationalError):
                raise UserError(f"{path} cannot be opened: {damage}") from damage
            aside = path.with_name(path.name + DAMAGED)
            path.replace(aside)
            self.told = f"{path} was damaged ({damage}): it is kept as {aside}, and all is played"
            self._open(path)

    def _open(self, path: Path) -> None:
        self._database = sqlite3.connect(path, timeout=5.0, isolation_level=None)
        self._database.execute("PRAGMA locking_mode = EXCLUSIVE")
        self._database.execute(TABLE)
        if (found := self._database.execute("PRAGMA quick_check").fetchone()) != ("ok",):
            raise sqlite3.DatabaseError(found[0])

    def __exit__(self, *_: object) -> None:
        self._database.close()

    def __contains__(self, key: str) -> bool:
        return self._find(key) is not None

    def __getitem__(self, key: str) -> dict[str, Any]:
        if (row := self._find(key)) is None:
            raise KeyError(key)
        told: dict[str, Any] = json.loads(row[0])
        return told

    def keep(self, key: str, told: dict[str, Any]) -> None:
        """For good when this returns."""
        text = json.dumps(told, sort_keys=True)
        self._database.execute("INSERT OR REPLACE INTO runs VALUES (?, ?)", (key, text))

    def _find(self, key: str) -> Any:
        return self._database.execute("SELECT told FROM runs WHERE key = ?", (key,)).fetchone()
