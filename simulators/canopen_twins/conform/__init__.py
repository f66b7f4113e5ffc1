"""A conformance test of a slave: topics from CiA 301, 305 and 306, played by us on any bus.

    topic.py    what a topic is, and how it ends      tester.py   what topics are written in
    twin.py     a twin on a bench as the slave
    bus.py      a bench, or a bus in real time        run.py      all topics, and a verdict

Each of the other files has the topics of one group, or of two that belong together. What is right
is written in the standard or in a manual, never in what a twin does.
"""

from canopen_twins.conform.bus import RealBus
from canopen_twins.conform.run import GROUPS, conform, topics
from canopen_twins.conform.topic import Topic
from canopen_twins.conform.twin import conform_twin, slave_of

__all__ = ["GROUPS", "RealBus", "Topic", "conform", "conform_twin", "slave_of", "topics"]
