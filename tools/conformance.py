"""Plays the conformance test and writes docs/conformance.md: `python -m tools.conformance`."""

from collections.abc import Iterator, Mapping
from pathlib import Path

from canopen_twins import devices
from canopen_twins.conform import GROUPS, conform_twin, topics
from canopen_twins.scenario import Kind, Outcome
from tools.proofs import shipped

ROOT = Path(__file__).parent.parent
PAGE = ROOT / "docs" / "conformance.md"
FILE = ROOT / "docs" / "examples" / "io-block" / "io_block.device.yaml"
WORDS = {Kind.PASS: "pass", Kind.SKIP: "n/a", Kind.FAIL: "FAIL"}
HEAD = """# Conformance

Written by `python -m tools.conformance`, which plays every topic of `canopen-twin conform`
against each device as it is delivered, and against the twin of a file, that of the
[example io-block](examples/io-block/). A test keeps this page true.

The groups and their sizes are those of CiA's conformance test (127 topics), to which LSS is
added; the topics are written by us, from CiA 301, 305 and 306. n/a is not applicable: the device
has nothing of the kind, or its manual wants something else, and the words say where it stands.
How to test a slave of your own: [How to test conformance](how-to/test-conformance.md).
"""

Results = Mapping[str, Mapping[str, Outcome]]
"""Of each twin, by the numbers of the topics."""


def main() -> None:
    """Play and write."""
    PAGE.write_text(page(results()), "utf-8")
    print(PAGE)


def results() -> Results:
    """Of every device, and of the twin of a file."""
    twins = {name: name for name in shipped()} | {FILE.name: str(FILE)}
    return {title: _played(title, name) for title, name in twins.items()}


def _played(title: str, name: str) -> Mapping[str, Outcome]:
    verdict = conform_twin(title, devices.create(name))
    return {outcome.topic: outcome for outcome in verdict.outcomes}


def page(found: Results) -> str:
    """The whole document."""
    titles = {group.number: group.title for group in GROUPS}
    lines = [HEAD, *_counts(found)]
    for number, title in titles.items():
        lines += ["", f"## {number} {title}", "", _line("", "topic", "source", *found)]
        lines.append(_line(*["---"] * (3 + len(found))))
        for topic in topics():
            if topic.number.split(".")[0] == str(number):
                cells = [_cell(outcomes[topic.number]) for outcomes in found.values()]
                lines.append(_line(topic.number, topic.title, topic.source, *cells))
    return "\n".join([*lines, ""])


def _counts(found: Results) -> Iterator[str]:
    yield _line("", *found)
    yield _line(*["---"] * (1 + len(found)))
    for kind, word in WORDS.items():
        counts = [
            sum(each.kind is kind for each in outcomes.values()) for outcomes in found.values()
        ]
        yield _line(word, *map(str, counts))


def _cell(outcome: Outcome) -> str:
    seen = outcome.seen.removeprefix("not applicable: ")
    return "pass" if outcome.kind is Kind.PASS else f"{WORDS[outcome.kind]}: {seen}"


def _line(*cells: str) -> str:
    return f"| {' | '.join(cells)} |"


if __name__ == "__main__":
    main()
