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
COLUMNS = """SELECT t.name, c.name FROM sqlite_master AS t, pragma_table_info(t.name) AS c
WHERE t.type IN ('table', 'view')"""
OURS = [("runs", "key"), ("runs", "told")]
UNREADABLE = "SELECT count(*) FROM runs WHERE NOT json_valid(told)"
DAMAGED = ".bad"
PATIENCE = 5.0  # seconds of real time for who is just ending


class Results(AbstractContextManager["Results"]):
    """What came of runs by their keys; each is kept at once, whole or not at all.

    Only one process has the file. A key says all that a run depends on, so what others have left in
    it may stay there.
    """

    def __init__(self, path: Path, patience: float = PATIENCE) -> None:
        """Raises `UserError` if the file cannot be opened; a damaged one is kept aside, with a line
        of `told`."""
        self.told = ""
        self._path = path = plain_file(path)
        try:
            self._database = self._opened(patience)
        except sqlite3.OperationalError as failure:
            if "locked" in str(failure):
                raise UserError(f"{path} belongs to another run") from failure
            raise UserError(f"{path} cannot be opened: {failure}") from failure
        except sqlite3.DatabaseError as damage:
            aside = path.with_name(path.name + DAMAGED)
            path.replace(aside)
            self.told = f"{path} was damaged ({damage}): it is kept as {aside}, and all is played"
            self._database = self._opened(patience)

    def _opened(self, patience: float) -> sqlite3.Connection:
        database = sqlite3.connect(self._path, timeout=patience, isolation_level=None)
        try:
            database.execute("PRAGMA locking_mode = EXCLUSIVE")
            database.execute("BEGIN EXCLUSIVE")  # from here on, as nothing is ever let go
            if [*database.execute(COLUMNS)] not in ([], OURS):
                raise UserError(f"{self._path} is a database of something else")
            database.execute(TABLE)
            database.execute("COMMIT")
            if (found := database.execute("PRAGMA quick_check").fetchone()) != ("ok",):
                raise sqlite3.DatabaseError(found[0])
            if (count := database.execute(UNREADABLE).fetchone()) != (0,):
                raise sqlite3.DatabaseError(f"{count[0]} runs cannot be read")
        except BaseException:
            database.close()
            raise
        return database

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
        """For good when this returns; raises `UserError` if it cannot be."""
        text = json.dumps(told, sort_keys=True)
        try:
            self._database.execute("INSERT OR REPLACE INTO runs VALUES (?, ?)", (key, text))
        except sqlite3.OperationalError as failure:
            raise UserError(f"{self._path} cannot be written: {failure}") from failure

    def _find(self, key: str) -> Any:
        return self._database.execute("SELECT told FROM runs WHERE key = ?", (key,)).fetchone()
