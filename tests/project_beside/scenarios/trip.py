"""A scenario of the project's own, in Python."""

SPEEDS = (0, 1500, 3000)
