"""The panel: one page that needs nothing but the port, and what a browser lets it do."""

from base64 import b64encode
from functools import cache
from hashlib import sha256
from importlib.resources import files
from typing import NamedTuple

SCRIPTS = ("port.js", "chart.js", "forms.js", "frames.js", "panel.js")


class Page(NamedTuple):
    """The page, and its policy: its own script and style, and the port it comes from."""

    html: str
    policy: str


@cache
def page() -> Page:
    """Put together of the files beside it."""
    folder = files("canopen_twins.live.control") / "panel"
    script = "\n".join((folder / name).read_text("utf-8") for name in SCRIPTS)
    style = (folder / "panel.css").read_text("utf-8")
    html = (folder / "index.html").read_text("utf-8")
    html = html.replace("{style}", style).replace("{script}", script)
    policy = (
        f"default-src 'none'; script-src '{_hash(script)}'; style-src '{_hash(style)}';"
        " connect-src 'self'; img-src data:; base-uri 'none'; frame-ancestors 'none'"
    )
    return Page(html, policy)


def _hash(text: str) -> str:
    return f"sha256-{b64encode(sha256(text.encode()).digest()).decode()}"
