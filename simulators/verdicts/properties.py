"""A verdict as flat pairs of texts, as test reports can keep them."""

from collections.abc import Iterator

from simulators.replay import Kind, Verdict


def properties(verdict: Verdict) -> Iterator[tuple[str, str]]:
    """What came of it; `canopen_outcome` is there for each outcome that did not pass."""
    yield "canopen_scenario", verdict.file
    yield "canopen_verdict", verdict.kind.value
    for kind in Kind:
        count = sum(outcome.kind is kind for outcome in verdict.outcomes)
        yield f"canopen_{kind.lower()}", str(count)
    yield "canopen_seed", str(verdict.seed)
    yield "canopen_seconds", f"{verdict.seconds:.6f}"
    for each in verdict.outcomes:
        if each.kind is not Kind.PASS:
            told = f"{each.kind} {each.time:.6f} s {verdict.file}:{each.line}"
            yield "canopen_outcome", f"{told}: {each.what}: {each.seen}"
