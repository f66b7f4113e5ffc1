from textwrap import dedent

import pytest

# what a run inside this process imports first, it would forget at its end, but for what packages
# have as attributes: two modules of one name
import canopen_twins.cli.check
import canopen_twins.live.twin
import canopen_twins.scenario.play
import canopen_twins.scenario.verdict  # noqa: F401

HEAD = "version: 1\nname: {name}\nnode: {{device: topcon, node_id: 5}}\nsteps:\n"


@pytest.fixture
def run(pytester):
    """Run a test module of this text, or what is there already."""

    def run(source, *options):
        if source is not None:
            pytester.makepyfile(source)
        return pytester.runpytest_inprocess("-p", "no:cacheprovider", *options)

    return run


@pytest.fixture
def story(pytester):
    """Write a scenario file; its steps begin in line 5."""

    def story(file, steps, name="A short story"):
        path = pytester.path / file
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(HEAD.format(name=name) + dedent(steps) + "\n")

    return story
