"""What is not the same of two records before anything is on the bus."""

from collections.abc import Iterator, Mapping

from simulators.record.about import About
from simulators.record.compare import compare
from simulators.record.recorded import Recorded
from simulators.record.side import Side

LONGEST = 120  # characters of a value


def other_inputs(left: Side, right: Side) -> Iterator[str]:
    """A line for each: versions, seed, devices, settings, the scenario."""
    if left.recorded is None or right.recorded is None:
        return
    ours, theirs = _flat(left.recorded.about), _flat(right.recorded.about)
    for name in sorted(ours.keys() | theirs.keys()):
        one, other = ours.get(name, "none"), theirs.get(name, "none")
        if one != other:
            yield f"{name}: {_short(one)} in {left.name}, {_short(other)} in {right.name}"
    yield from _scenarios(left.recorded, right.recorded)


def _flat(about: About) -> Mapping[str, str]:
    """The content of a run.json by the names of its leaves."""
    content = about.model_dump(include={"kind", "scenario", "seed"})
    flat = {name: _word(value) for name, value in content.items()}
    flat |= {f"version of {name}": number for name, number in about.versions.items()}
    flat |= {f"content of {name}": digest for name, digest in about.files.items()}
    for node in about.nodes:
        flat[f"device of {node.name}"] = node.device
        flat[f"memory of {node.name}"] = _word(node.memory)
        flat |= {f"{key} of {node.name}": _word(each) for key, each in node.settings.items()}
    return flat


def _word(value: object) -> str:
    return "none" if value is None else str(value)


def _short(text: str) -> str:
    return text if len(text) <= LONGEST else f"{text[:LONGEST]}..."


def _scenarios(left: Recorded, right: Recorded) -> Iterator[str]:
    """The first line of the files that is another one."""
    if left.about.scenario is None or right.about.scenario is None:
        return
    lines = [side.scenario.read_bytes().splitlines() for side in (left, right)]
    if found := compare(*lines):
        place = f"line {found.common + 1} of the scenario"
        yield f"{place}: {_line(found.left)} / {_line(found.right)}"


def _line(lines: tuple[bytes, ...]) -> str:
    return repr(_short(lines[0].decode("utf-8", "replace"))) if lines else "none"
