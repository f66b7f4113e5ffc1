"""A simulator of the project's own."""


def flow(speed):
    """In litres per minute, of a speed in rpm."""
    return speed / 100
