"""The page of the control port, in a real browser that knows nothing but its address."""

import os
import re
import shutil
from contextlib import closing
from http.client import HTTPConnection
from pathlib import Path

import pytest

from canopen_twins.live.control.page import page

from .served import served

CHROMIUM = shutil.which("chromium")
DRIVER = shutil.which("chromedriver")
PICTURE = Path(__file__).parents[2] / "docs" / "pictures" / "panel.png"
SWITCHES = (
    *("headless=new", "no-sandbox", "disable-gpu", "disable-dev-shm-usage", "disable-quic"),
    *("disable-background-networking", "disable-sync", "disable-component-update", "no-first-run"),
)
PATIENCE = 20  # seconds
RUN_AT_200_V = ("605#2B112000A00F0000", "605#2B102000D0070000", "605#2B14200001000000")
in_a_browser = [
    pytest.mark.browser,
    pytest.mark.skipif(CHROMIUM is None or DRIVER is None, reason="needs chromium and its driver"),
]


@pytest.fixture(scope="module")
def browser():
    """Chromium, 1400 by 1500 pixels."""
    from selenium import webdriver  # noqa: PLC0415

    options = webdriver.ChromeOptions()
    options.binary_location = CHROMIUM
    for switch in SWITCHES:
        options.add_argument(f"--{switch}")
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    with webdriver.Chrome(options, webdriver.ChromeService(DRIVER)) as browser:
        browser.set_window_size(1400, 1500)
        yield browser


class Panel:
    """What a person sees and does."""

    def __init__(self, browser):
        self.browser = browser

    def at(self, identifier):
        return self.browser.find_element("id", identifier)

    def reads(self, identifier, text):
        """Wait until it does."""
        return self._wait(lambda: re.search(text, self.at(identifier).text), (identifier, text))

    def presses(self, identifier, label):
        buttons = self.at(identifier).find_elements("tag name", "button")
        (button,) = [each for each in buttons if each.text == label]
        button.click()

    def writes(self, name, text):
        from selenium.webdriver.common.keys import Keys  # noqa: PLC0415

        field = self.browser.find_element("css selector", f"#live-settings [name={name}]")
        field.clear()
        field.send_keys(text, Keys.TAB)

    def picture_of_the_curves(self):
        script = "return [...document.querySelectorAll('canvas')].map(each => each.toDataURL())"
        return self.browser.execute_script(script)

    def moves(self, before):
        return self._wait(lambda: self.picture_of_the_curves() != before, "the curves")

    def _wait(self, seen, what):
        from selenium.common.exceptions import (  # noqa: PLC0415
            StaleElementReferenceException,
            TimeoutException,
        )
        from selenium.webdriver.support.wait import WebDriverWait  # noqa: PLC0415

        ignored = [StaleElementReferenceException]
        try:
            waiting = WebDriverWait(self.browser, PATIENCE, 0.05, ignored)
            return waiting.until(lambda _: seen())
        except TimeoutException:
            raise AssertionError(f"not seen: {what}") from None


@pytest.fixture
def panel(browser, supplies):
    browser.get(f"http://{supplies.address}")
    panel = Panel(browser)
    panel.reads("link", "connected")
    panel.reads("state-title", "supply, node 5")
    yield panel
    log = browser.get_log("browser")
    assert [each for each in log if each["source"] != "network"] == []  # a refusal is no mistake


@pytest.fixture(scope="module")
def supplies():
    nodes = {
        "supply": ("topcon", {"node_id": 5, "load": "resistor 10 ohm"}),
        "charger": ("charger", {"node_id": 6}),
    }
    with served(nodes) as port:
        yield port


class TestInABrowser:
    pytestmark = in_a_browser

    def test_a_fault_is_injected_seen_and_cleared(self, panel):
        panel.at("fault").send_keys("interlock_open")
        panel.presses("inject", "Inject")
        panel.reads("active", "interlock_open")
        panel.reads("emcy", r"supply: EMCY 9000h .*interlock loop open")
        panel.reads("errors-now", "9000h interlock loop open")
        panel.reads("band", "error")
        panel.presses("active", "Clear")
        panel.reads("active", "^$")

    def test_a_page_that_was_left_keeps_no_connection_from_the_next(self, panel):
        address = panel.browser.current_url
        for _ in range(6):  # as many as a browser has to one place
            panel.browser.get("about:blank")
            panel.browser.get(address)
            panel.reads("state-title", "supply, node 5")

    def test_a_form_has_the_parameters_of_its_fault_and_says_what_is_wrong(self, panel):
        panel.at("fault").send_keys("heartbeat_late")
        panel.reads("parameters", r"by how much, in s")
        field = panel.browser.find_element("css selector", "#parameters [name=seconds]")
        field.clear()
        field.send_keys("soon")
        panel.presses("inject", "Inject")
        panel.reads("told", "wants a number, not 'soon'")

    def test_a_load_is_changed_and_the_curve_moves(self, panel, supplies):
        with supplies.master() as send:
            for frame in ("605#2B14200002000000", *RUN_AT_200_V):
                send(frame)
            panel.reads("report", r"current \[A\] (19|20)\b")
            before = panel.picture_of_the_curves()
            panel.writes("load", "resistor 20 ohm")
            panel.reads("report", r"current \[A\] (9\.|10\b)")
            panel.moves(before)
            if os.environ.get("CANOPEN_TWINS_PICTURES"):
                panel.browser.save_screenshot(str(PICTURE))

    def test_frames_stand_in_words_are_filtered_paused_and_explained(self, panel, supplies):
        with supplies.master() as send:
            send("605#2B1020000F270000")
            panel.reads("frames", "SDO abort 0x2010:00 Voltage reference")
            panel.at("filter").send_keys("abort")
            assert "heartbeat" not in panel.at("frames").text
            panel.presses("bus", "585#8010200031000906")
            panel.reads("reasons-list", "is above 4000")
            panel.presses("reasons", "Close")
            panel.presses("bus", "Pause")
            send("605#4000100000000000")
            panel.at("filter").clear()
            panel.at("filter").send_keys("Device Type")
            assert "0x1000" not in panel.at("frames").text
            panel.presses("bus", "Go on")
            panel.reads("frames", "SDO read 0x1000:00 Device Type")

    def test_another_node_is_chosen_by_the_keyboard_and_switched_off(self, panel):
        from selenium.webdriver.common.keys import Keys  # noqa: PLC0415

        panel.browser.find_element("tag name", "body").send_keys(Keys.TAB, Keys.TAB, Keys.ENTER)
        panel.reads("state-title", "charger, node 6")
        panel.presses("state", "Power off")
        panel.reads("band", "power off")
        panel.presses("state", "Power on")
        panel.reads("report", "release")

    def test_a_scenario_is_told_why_it_cannot_be_here(self, panel):
        panel.at("stories").send_keys("topcon_mains.yaml")
        panel.presses("play", "Start")
        panel.reads("told", "here is supply, charger")

    def test_a_narrow_screen_has_no_scroll_bar_across(self, panel):
        panel.browser.set_window_size(400, 900)
        try:
            wide = (
                "return document.documentElement.scrollWidth - document.documentElement.clientWidth"
            )
            assert panel.browser.execute_script(wide) == 0
        finally:
            panel.browser.set_window_size(1400, 1500)

    @pytest.mark.parametrize("scheme", ["light", "dark"])
    def test_the_page_is_light_or_dark_as_the_reader_has_it(self, panel, scheme):
        features = [{"name": "prefers-color-scheme", "value": scheme}]
        panel.browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": features})
        colour = panel.browser.find_element("tag name", "body").value_of_css_property("color")
        red = int(re.search(r"\d+", colour)[0])
        assert (red > 128) is (scheme == "dark")


def test_the_page_loads_nothing_and_may_reach_the_port_alone():
    html, policy = page()
    assert not re.search(r"(src|href)=(?!\"data:)", html)
    assert "http" not in html
    assert policy.startswith("default-src 'none'; script-src 'sha256-")
    assert "connect-src 'self'" in policy


def test_the_port_serves_the_page_with_its_policy(supplies):
    with closing(HTTPConnection(*supplies.address, timeout=PATIENCE)) as connection:
        connection.request("GET", "/")
        answer = connection.getresponse()
        assert answer.read().decode() == page().html
        assert answer.headers["Content-Security-Policy"] == page().policy
    assert "topcon_overvoltage.yaml" in supplies.get("/scenarios").body
