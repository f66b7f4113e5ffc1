from collections.abc import Callable
from io import StringIO
from pathlib import Path
from xml.etree import ElementTree

import pytest
from probe import Probe

from canopen_twins import devices
from canopen_twins.device.chart import Band, Chart, Curve, Mood
from canopen_twins.record.plot import Plot
from canopen_twins.record.plot.run import Run
from canopen_twins.scenario import load, play

HEAD = "version: 1\nname: {}\nnode: {{device: meter, node_id: 5}}\nsteps:\n"
SVG = "{http://www.w3.org/2000/svg}"


class Meter(Probe):
    """A probe whose level is drawn, and whether it is high."""

    @property
    def chart(self):
        level = Curve("Level", "m", lambda: self.level, lambda: self.level / 2)
        states = [Band("low", Mood.ACTIVE), Band("high", Mood.ERROR)]
        return Chart([level], lambda: states[self.level > 100])


def find(name):
    return Meter if name == "meter" else devices.find(name)


@pytest.fixture
def story(tmp_path) -> Callable[..., object]:
    """The scenario of some steps of a meter; they begin in line 5 of the file."""

    def story(steps, name="A story"):
        path = tmp_path / "story.yaml"
        path.write_text(HEAD.format(name) + steps, encoding="utf-8")
        return load(path, find)

    return story


@pytest.fixture
def observed(story) -> Callable[[str], Run]:
    """Whoever has looked at a meter through some steps."""

    def observed(steps):
        observers = []
        play(story(steps), observers=[lambda *run: observers.append(Run(*run))])
        return observers[0]

    return observed


@pytest.fixture
def drawn(story, tmp_path) -> Callable[..., Path]:
    """The picture of some steps of a meter."""

    def drawn(steps, suffix="svg", **told):
        return draw(story(steps, **told), tmp_path / f"run.{suffix}")

    return drawn


def draw(scenario, path):
    """The picture of a scenario."""
    plot = Plot(path)
    play(scenario, StringIO(), observers=[plot.begin])
    plot.save()
    return path


class Svg:
    """A picture as a reader meets it."""

    def __init__(self, text):
        self.root = ElementTree.fromstring(text)

    @property
    def texts(self):
        return [each.text for each in self.root.iter(f"{SVG}text")]

    def text_at(self, text):
        """Where a text begins or ends, from the left."""
        (found,) = (each for each in self.root.iter(f"{SVG}text") if each.text == text)
        return float(found.get("x") or found.get("transform").split("(")[1].split()[0])

    def path(self, identifier):
        """The corners of the line with this id."""
        (group,) = (each for each in self.root.iter(f"{SVG}g") if each.get("id") == identifier)
        (path,) = group.iter(f"{SVG}path")
        numbers = [word for word in path.get("d").split() if word not in "ML"]
        return list(zip(map(float, numbers[::2]), map(float, numbers[1::2]), strict=True))

    def lines(self, colour):
        """The corners of every path with a stroke of this colour."""
        for path in self.root.iter(f"{SVG}path"):
            if f"stroke: {colour.lower()}" in path.get("style", "").lower():
                yield [float(word) for word in path.get("d").split() if word not in "MLz"]
