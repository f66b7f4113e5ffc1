"""A verdict as flat pairs of texts, as test reports can keep them."""

from collections.abc import Iterator

from simulators.replay import Kind, Verdict

Pair = tuple[str, str]


def summary(verdict: Verdict) -> Iterator[Pair]:
    """What came of the whole."""
    yield "canopen_scenario", verdict.file
    yield "canopen_verdict", verdict.kind.value
    for kind in Kind:
        count = sum(outcome.kind is kind for outcome in verdict.outcomes)
        yield f"canopen_{kind.lower()}", str(count)
    yield "canopen_seed", str(verdict.seed)
    yield "canopen_seconds", f"{verdict.seconds:.6f}"


def properties(verdict: Verdict) -> Iterator[Pair]:
    """The same, and a `canopen_outcome` for each outcome that did not pass."""
    yield from summary(verdict)
    for each in verdict.outcomes:
        if each.kind is not Kind.PASS:
            told = f"{each.kind} {each.time:.6f} s {verdict.file}:{each.line}"
            yield "canopen_outcome", f"{told}: {each.what}: {each.seen}"
