"""How the command ends: what scripts and CI ask for."""

OK = 0
FAILED = 1
"""An expectation failed, or two runs are not the same; also a bug, with its traceback."""
WRONG_INPUT = 2
INTERRUPTED = 130
"""By SIGINT, as shells have it."""
NO_READER = 141
"""Whoever read our output has seen enough; as of SIGPIPE."""
