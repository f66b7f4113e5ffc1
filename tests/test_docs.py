import os
import re
import shlex
import sys
from dataclasses import fields
from pathlib import Path
from typing import Literal, get_args, get_origin, get_type_hints

import pytest

# pytester forgets modules that come while it works: an error would then be of another class, and
# numpy refuses to come a second time
import canopen_twins.bench.simulated_time.scheduler
import canopen_twins.record.plot.figure
import canopen_twins.scenario.compile  # noqa: F401
from canopen_twins import devices
from canopen_twins.cli import main
from canopen_twins.device.settings import about

DOCS = Path(__file__).parent.parent / "docs"
PAGES = sorted(DOCS.rglob("*.md"))
BLOCK = re.compile(r"^```(\w+)(?: file=(\S+))?\n(.*?)^```$", re.MULTILINE | re.DOTALL)
LINK = re.compile(r"\]\((?!https?:)([^)#\s]+)")


class Reader:
    """Does what a page tells to do: one namespace, one directory, block by block."""

    def __init__(self, page, pytester):
        self.page = page
        self.pytester = pytester
        self.namespace = {"__name__": "__main__"}
        self.programs = {"canopen-twin": main, "pytest": self.pytest}

    def read(self):
        text = self.page.read_text("utf-8")
        for block in BLOCK.finditer(text):
            language, file, code = block.groups()
            if file:
                Path(file).parent.mkdir(parents=True, exist_ok=True)
                Path(file).write_text(code, "utf-8")
            elif language == "python":
                above = "\n" * (text.count("\n", 0, block.start()) + 1)  # for tracebacks
                exec(compile(above + code, str(self.page), "exec"), self.namespace)
            elif language == "console":
                self.type(code)

    def type(self, code):
        for line in code.splitlines():
            if line.startswith("$ "):
                command, _, code = line[2:].partition("  # exits with ")
                program, *arguments = shlex.split(command)
                assert self.programs[program](arguments) == int(code or 0), line

    def pytest(self, arguments):
        return self.pytester.runpytest_inprocess("-p", "no:cacheprovider", *arguments).ret


def page_of(device):
    return (DOCS / "devices" / f"{device}.md").read_text("utf-8")


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(DOCS)))
def test_what_a_page_shows_works(page, pytester, monkeypatch):
    pytester.syspathinsert()  # as for whoever types it in this directory
    monkeypatch.setenv("PATH", f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}")
    Reader(page, pytester).read()


@pytest.mark.parametrize(
    "page", [DOCS.parent / "README.md", *PAGES], ids=lambda page: str(page.relative_to(DOCS.parent))
)
def test_a_page_links_to_what_is_there(page):
    links = LINK.findall(page.read_text("utf-8"))
    assert [link for link in links if not (page.parent / link).exists()] == []


def test_no_two_decisions_have_the_same_number():
    numbers = [page.name[:4] for page in sorted((DOCS / "decisions").glob("*.md"))]
    assert numbers == sorted(set(numbers))


def test_the_tutorial_shows_what_a_deaf_master_is_told(pytester):
    blocks = BLOCK.findall((DOCS / "tutorial.md").read_text("utf-8"))
    for _, file, code in blocks:
        if file in ("trip.yaml", "test_deaf.py"):
            Path(file).write_text(code, "utf-8")
    said = pytester.runpytest_inprocess("-p", "no:cacheprovider", "test_deaf.py").outlines
    (shown,) = [code for language, _, code in blocks if language == "text"]
    story = "\n".join(said).partition("short test summary")[0]  # which repeats it where CI is set
    told = [line for line in story.splitlines() if line.startswith("  FAIL")]
    assert told == shown.splitlines()


def test_the_tutorial_of_files_shows_what_check_and_why_say(pytester, capsys):
    blocks = BLOCK.findall((DOCS / "tutorial-eds.md").read_text("utf-8"))
    Path("drive.eds").write_text(next(code for _, file, code in blocks if file == "drive.eds"))
    shown = [code for language, _, code in blocks if language == "text"]
    assert main(["check", "drive.eds"]) == 0
    assert main(["why", "drive.eds", "Target speed=3001", "-n", "5"]) == 0
    assert capsys.readouterr().out == "".join(shown)


@pytest.mark.parametrize(
    "text", ["```python\nassert 0\n```", "```console\n$ canopen-twin play nothing\n```"]
)
def test_what_does_not_work_is_found(text, pytester):
    page = pytester.path / "page.md"
    page.write_text(f"{text}\n")
    with pytest.raises(AssertionError):
        Reader(page, pytester).read()


@pytest.mark.parametrize("device", devices.names())
def test_the_page_of_a_device_has_every_setting_and_every_assumption_behind_one(device):
    page = page_of(device)
    settings = fields(devices.find(device).settings)
    assert [entry.name for entry in settings if f"`{entry.name}`" not in page] == []
    assumed = {
        number for entry in settings for number in re.findall(r"A-\d+", about(entry).assumed)
    }
    assert [number for number in sorted(assumed) if f"| {number} |" not in page] == []
    assert [entry.name for entry in settings if about(entry).assumed.strip("A-0123456789, ")] == []


@pytest.mark.parametrize("device", devices.names())
def test_the_page_of_a_device_has_the_words_of_every_setting_default_first(device):
    page = page_of(device)
    settings = devices.find(device).settings
    for name, kind in get_type_hints(type(settings)).items():
        if get_origin(kind) is Literal:
            assert f"`{name}`: `" + "`, `".join(get_args(kind)) + "`" in page
            assert get_args(kind)[0] == getattr(settings, name)


@pytest.mark.parametrize("device", devices.names())
def test_the_page_of_a_device_has_every_fault_with_its_parameters(device):
    rows = [line for line in page_of(device).splitlines() if line.startswith("| `")]
    for name, fault in devices.create(device).faults.items():
        (row,) = [row for row in rows if row.startswith(f"| `{name}` |")]
        assert [told for told in fault.parameters if f"`{told}`" not in row] == [], name
