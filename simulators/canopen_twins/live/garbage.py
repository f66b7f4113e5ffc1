"""When Python looks for garbage in a process that answers frames: often, and little each time.

A search goes through all that is as old as what it looks for. By Python's own habits that is
thousands of objects and 5 ms, or ten thousands and 40 ms, in the middle of whatever makes the
next object: an order, or a boot, whose slave before it is garbage.
"""

import gc
from collections.abc import Iterator
from contextlib import contextmanager

PORTIONS = (700, 1, 10)
"""New objects that set off a search among them; searches of that kind, after which those that were
left are gone through (Python's own: 10); and of that kind, after which all the rest is."""
FEW = 1  # of these searches, after which a quiet bus is the moment: what a boot leaves behind


@contextmanager
def in_portions() -> Iterator[None]:
    """What there is by now is left out of the search, and what comes is gone through in portions.

    All that has been imported would hold up answers for 50 ms.
    """
    before = gc.get_threshold()
    gc.freeze()
    gc.collect()  # it notes that nothing is left: all the rest need not become a quarter more
    gc.set_threshold(*PORTIONS)
    try:
        yield
    finally:
        gc.set_threshold(*before)


def search_while_quiet() -> None:
    """Go through all the rest, if it is `in_portions` and enough has come to it: nobody waits."""
    if gc.get_threshold() == PORTIONS and gc.get_count()[2] >= FEW:
        gc.collect()
