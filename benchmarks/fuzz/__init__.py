"""What may happen to a twin, at random: events, a world that checks them, stories of failures.

`python -m benchmarks.fuzz topcon --frames 10000000` is the nightly command; the state machine of
the tests draws its events from here, too.
"""
