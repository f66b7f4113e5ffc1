"""A master as people write them, with threads, sleeps and time-outs; it knows of no bench."""

import threading
import time
from queue import Queue
from threading import Event, Lock
from time import sleep as pause

import canopen

from canopen_twins.slave.dictionary import dictionary


class Poller(threading.Thread):
    """Reads an object again and again; `readings` are (time, value), no value if none came."""

    def __init__(self, node, index, period):
        super().__init__(name=f"poller of node {node.id}")
        self.node, self.index, self.period = node, index, period
        self.readings = []
        self.stopping = Event()

    def run(self):
        while not self.stopping.is_set():
            try:
                value = self.node.sdo[self.index].raw
            except canopen.SdoCommunicationError:
                value = None
            self.readings.append((round(time.monotonic(), 6), value))
            self.stopping.wait(self.period)


class Master:
    """Polls every node in a thread, and works on the emergencies in another one."""

    def __init__(self, dictionaries):
        self.network = canopen.Network().connect(interface="socketcan", channel="can0")
        self.nodes = [self.network.add_node(node_id, od) for node_id, od in dictionaries.items()]
        self.errors, self.lock, self.queue = [], Lock(), Queue()
        self.worker = threading.Thread(target=self.work, daemon=True)
        self.pollers = [Poller(node, 0x2000, 0.005 + node.id / 1000) for node in self.nodes]
        for node in self.nodes:
            node.emcy.add_callback(self.queue.put)
        for thread in (self.worker, *self.pollers):
            thread.start()

    def work(self):
        while (error := self.queue.get()) is not None:
            with self.lock:
                pause(0.002)
                self.errors.append((round(time.monotonic(), 6), error.code))

    def close(self):
        self.queue.put(None)
        for poller in self.pollers:
            poller.stopping.set()
        for thread in (self.worker, *self.pollers):
            thread.join()
        self.network.disconnect()


def a_minute_later():
    """Sleeps, and says how long it took by every clock it has."""
    start = time.time(), time.monotonic(), time.perf_counter(), time.time_ns(), time.monotonic_ns()
    pause(60)
    end = time.time(), time.monotonic(), time.perf_counter(), time.time_ns(), time.monotonic_ns()
    return [round(late - early, 6) for early, late in zip(start, end, strict=True)]


def connect(node_id=5, **config):
    """A node as an unmodified master gets at it."""
    network = canopen.Network().connect(interface="socketcan", channel="can0", **config)
    return network.add_node(node_id, dictionary("topcon.eds", node_id))
