"""A master that lets consumers to a genset by the gateway of its governor, while all is well."""

import logging
import queue
import struct
import threading
import time

import canopen
from canopen.sdo.exceptions import SdoError

NODE_ID, OWN_ID = 1, 127
IDENTITY = {1: 0x161, 2: 0x1B59}  # vendor and product
CYCLE = 0.1  # seconds between two RPDOs; the governor misses them after 200 ms
LOST_AFTER, POLL = 0.7, 2.0  # seconds
TRIES, GAP, PAUSE, SETTLE = 3, 0.005, 0.05, 0.5  # of an SDO read; seconds before the next
KEEP_AWAY = 1 << 4  # bit 5 of RPDO1
ERRORS = 0x2000  # sub-indices 1 to 6, as TPDO1 and TPDO2 have them
log = logging.getLogger(__name__)


class GensetError(Exception):
    """The genset is not as it should be: consumers have to be kept away, until it is."""


class Genset:
    """One genset: how it is brought to where it may have consumers, and watched."""

    def __init__(self, network):
        self.network = network
        self.node = network.add_node(NODE_ID)
        self.news = queue.Queue()  # of callbacks, which leave the work to the main thread
        self.switches = KEEP_AWAY
        self.state = None
        self.heard = time.monotonic()
        self.over = threading.Event()
        self.node.nmt.add_heartbeat_callback(self.on_heartbeat)
        network.subscribe(0x180 + NODE_ID, self.on_errors)
        network.subscribe(0x280 + NODE_ID, self.on_errors)
        self.beating = threading.Thread(target=self.beat, name="beat", daemon=True)
        self.beating.start()

    def on_heartbeat(self, state):
        """Called by canopen, for a boot-up message too."""
        self.heard, self.state = time.monotonic(), state
        if state == 0:
            self.news.put("it has booted")

    def on_errors(self, can_id, data, timestamp):
        """Called by canopen for TPDO1 and TPDO2; what is not all zero tells of an error."""
        if any(data):
            self.news.put("errors")

    def beat(self):
        """What has to come all the time: heartbeat and switches."""
        while not self.over.wait(CYCLE):
            self.network.send_message(0x700 + OWN_ID, [5])
            self.network.send_message(0x200 + NODE_ID, struct.pack("<4H", self.switches, 0, 0, 0))

    def start(self):
        """From wherever it is to where it may have consumers."""
        while not self.news.empty():
            self.news.get()  # what comes from here on counts
        self.node.nmt.state = "PRE-OPERATIONAL"  # one that is stopped would not answer
        for sub, value in IDENTITY.items():
            if self.read(0x1018, sub, "<L") != value:
                raise GensetError("another device than expected")
        self.make_operational()
        self.expect_no_errors()
        self.no_news()
        self.switches &= ~KEEP_AWAY

    def make_operational(self):
        """Ask for it until a heartbeat tells so."""
        for _ in range(TRIES):
            self.node.nmt.state = "OPERATIONAL"
            end, self.state = time.monotonic() + LOST_AFTER, None
            while time.monotonic() < end:
                self.no_news()
                if self.state == 5:
                    return
                time.sleep(PAUSE)
        raise GensetError("it does not become operational")

    def expect_no_errors(self):
        """By SDO, as the PDO that tells of one may get lost; nobody can clear them from here."""
        if any(self.read(ERRORS, sub, "<H") for sub in range(1, 7)):
            raise GensetError("errors that it has not told")

    def watch(self, end):
        """Until then, or until something is wrong."""
        poll = time.monotonic() + POLL
        while time.monotonic() < end:
            if time.monotonic() - self.heard > LOST_AFTER or self.state != 5:
                raise GensetError("no heartbeat, or one of a state that nobody commanded")
            if time.monotonic() >= poll:
                self.expect_no_errors()
                poll = time.monotonic() + POLL
            try:
                raise GensetError(self.news.get(timeout=CYCLE))
            except queue.Empty:
                pass

    def read(self, index, sub, form):
        """A number; several times if need be, but not while there is news that matters more."""
        for _ in range(TRIES):
            self.no_news()
            time.sleep(GAP)  # an answer that comes twice is in by then, and dropped by canopen
            try:
                data = self.node.sdo.upload(index, sub)
                if len(data) == struct.calcsize(form):
                    return struct.unpack(form, data)[0]
            except SdoError as error:
                log.info("0x%04X: %s", index, error)
            time.sleep(PAUSE)
        raise GensetError(f"no access to 0x{index:04X}:{sub:02X}")

    def no_news(self):
        """Go on only if nothing has happened meanwhile."""
        if not self.news.empty():
            raise GensetError(self.news.get())

    def close(self):
        """Send nothing more."""
        self.over.set()
        self.beating.join()


def main(network: canopen.Network, seconds=30.0):
    """Do so for so long; a genset that is lost is started again and again."""
    genset = Genset(network)
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        try:
            genset.start()
            genset.watch(end)
        except GensetError as error:
            log.info("%s", error)
        genset.switches |= KEEP_AWAY
        time.sleep(SETTLE)
    genset.close()
