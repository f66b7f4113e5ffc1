import re
import shlex
from pathlib import Path

import pytest

from canopen_twins.cli import main

PAGE = Path(__file__).parents[2] / "docs" / "how-to" / "record-a-run.md"
BLOCK = re.compile(r"^```(\w+)(?: file=(\S+))?\n(.*?)^```$", re.MULTILINE | re.DOTALL)
COMMAND = re.compile(r"^\$ canopen-twin (.*?)(?:  # exits with \d)?\n((?:[^$].*\n)*)", re.MULTILINE)


@pytest.fixture
def said(capsys):
    """What a command prints."""

    def run(words):
        main(shlex.split(words))
        return capsys.readouterr().out

    return run


def test_the_page_shows_what_is_printed(said, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    shown = {}
    for language, file, text in BLOCK.findall(PAGE.read_text("utf-8")):
        if file:
            Path(file).write_text(text, "utf-8")
        elif language == "console":
            for words, output in COMMAND.findall(text):
                told = said(words)
                assert output in ("", told), words
                shown[words] = output
    assert [words for words, output in shown.items() if output] == [
        "diff before after",
        "diff after trip.asc",
    ]
