import re
from html.parser import HTMLParser

import pytest

from canopen_twins.record.plot.page import MOST_LINES
from canopen_twins.record.plot.run import MOST_FRAMES

STEPS = """\
- {at: 1, inject: {error: {code: 0x1234}}}
- {at: 2, clear: error}
- {at: 3, inject: heartbeat_stopped}
- {at: 4, expect: {value: {0x2100: 7}}}
"""
NAME = '"<script>alert(1)</script> & co"'


class Page(HTMLParser):
    """What a browser makes of a page: its elements, and its rows."""

    def __init__(self, text):
        super().__init__()
        self.tags, self.attributes, self.rows, self.text = [], [], [], {}
        self._open = ""
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        self.attributes += [(tag, *each) for each in attrs]
        self._open = tag
        if tag == "tr":
            self.rows.append([])

    def handle_endtag(self, tag):
        self._open = ""

    def handle_data(self, data):
        if self._open in ("td", "th") and data.strip():
            self.rows[-1].append(data)
        self.text[self._open] = self.text.get(self._open, "") + data


@pytest.fixture
def page(drawn):
    return Page(drawn(STEPS, "html", name=NAME).read_text("utf-8"))


def test_it_has_the_picture_and_the_verdict_in_words(page):
    assert page.tags.count("svg") == 1
    assert "FAIL" in page.text["span"]
    assert "probe" not in page.text["span"]
    assert "the last frames" not in page.text["span"]
    assert "meter: node 5, PRE-OPERATIONAL" in page.text["span"]


def test_it_needs_no_file_and_no_network_and_its_one_script_is_that_of_the_zoom(page):
    assert not {"link", "img", "iframe", "object"} & set(page.tags)
    assert page.tags.count("script") == 1
    assert "fetch" not in page.text["script"]
    assert {name for _, name, _ in page.attributes} & {"src", "onload", "onclick"} == set()
    links = [value for _, name, value in page.attributes if name.endswith("href")]
    assert all(link.startswith("#") for link in links)


def test_names_are_escaped(page):
    assert page.text["h1"].startswith("<script>alert(1)</script> & co")


def test_every_emergency_has_a_row_with_its_time_and_words(page):
    assert ["1.000000", "meter", "EMCY 1234h register 01h"] in page.rows
    assert ["2.000000", "meter", "EMCY 0000h register 00h no error left"] in page.rows


def test_every_fault_has_a_row_from_inject_to_clear_or_to_the_end(page):
    assert ["1.000000", "2.000000", "meter", "error(code=4660)"] in page.rows
    assert ["3.000000", "the end", "meter", "heartbeat_stopped"] in page.rows


def test_a_verdict_without_end_is_cut_off(drawn):
    steps = "- {at: 1, every: 0.01, times: 900, expect: {value: {0x2100: 7}}}\n"
    verdict = Page(drawn(steps, "html").read_text("utf-8")).text["span"].splitlines()
    assert len(verdict) == MOST_LINES + 1
    assert re.fullmatch(r"\.\.\. and \d+ lines more", verdict[-1])


def test_where_nothing_went_wrong_there_is_no_table_but_that_of_the_frames(drawn):
    page = Page(drawn("- {at: 1, nmt: start}\n", "html").read_text("utf-8"))
    assert page.tags.count("table") == 1
    assert page.rows[0] == ["at [s]", "from", "frame", "in words"]


def test_its_name_and_its_verdict_stand_there_once(page, drawn):
    text = drawn("- {at: 1, nmt: start}\n", "html", name="the only name").read_text("utf-8")
    assert re.findall(r"<(\w+)>the only name<", text) == ["title", "h1"]


def test_every_frame_has_a_row_in_words_with_its_sender(page):
    assert ["0.000000", "meter", "705#00", "boot-up"] in page.rows
    (emcy,) = [row for row in page.rows if row[2].startswith("085#341201")]
    assert (emcy[0], emcy[1], emcy[3]) == ("1.000000", "meter", "EMCY 1234h register 01h")


def test_frames_without_end_are_cut_off(drawn):
    steps = "- {at: 1, every: 0.001, times: 3000, send: 080#}\n"
    text = drawn(steps, "html").read_text("utf-8")
    assert re.search(rf"<p>\d+ more after the first {MOST_FRAMES}.</p>", text)
