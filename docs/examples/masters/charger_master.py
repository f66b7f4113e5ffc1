"""A master that keeps a charger at high voltage, and lets go of it at the first error."""

import logging
import queue
import struct
import time

from canopen.sdo.exceptions import SdoError

NODE_ID = 99
IDENTITY = {1: 0x24E, 2: 1}  # vendor and product
VOLTS, MICROAMPERES = 20_000, 4_000
HEARTBEAT, LOST_AFTER, CYCLE = 0.5, 1.25, 0.2  # seconds; the cycle is that of the TPDOs
RELEASE_EVERY, RELEASE_FOR = 0.25, 1.0  # seconds; the charger locks by itself after so long
RAMP, POLL = 1.5, 2.0  # seconds until there is high voltage, and between two looks by SDO
TRIES, GAP, PAUSE, SETTLE = 3, 0.005, 0.05, 0.5  # of an SDO access; seconds before the next
STATUS, RELEASE, CLEAR_ERROR = (0x6000, 1), (0x6200, 1), (0x2003, 1)
LOCKED, RELEASED = 0x00, 0x0F
ON, ERROR, HAS_RELEASE = 1 << 0, 1 << 1, 1 << 5
AN_ERROR = 0x01  # a warning is 0x05, and stops nothing
log = logging.getLogger(__name__)


class ChargerError(Exception):
    """The charger is not as it should be: it has to be locked, and started from the beginning."""


class Charger:
    """One charger: how it is brought to its voltage, watched and locked."""

    def __init__(self, network):
        self.network = network
        self.node = network.add_node(NODE_ID)
        self.news = queue.Queue()  # of callbacks, which leave the work to the main thread
        self.uncleared = set()  # numbers of errors
        self.status = 0
        self.heard = self.good = time.monotonic()
        self.state = None
        self.node.nmt.add_heartbeat_callback(self.on_heartbeat)
        self.node.emcy.add_callback(self.on_emergency)
        network.subscribe(0x180 + NODE_ID, self.on_status)

    def on_heartbeat(self, state):
        """Called by canopen, for a boot-up message too."""
        self.heard, self.state = time.monotonic(), state
        if state == 0:
            self.uncleared.clear()
            self.news.put("it has booted")

    def on_emergency(self, message):
        """Called by canopen; code 0 confirms that an error has been cleared."""
        kind, number = message.data[:2]
        if kind == AN_ERROR and message.code:
            self.uncleared.add(number)
            self.news.put(f"error {number}")
        elif kind == AN_ERROR:
            self.uncleared.discard(number)

    def on_status(self, can_id, data, timestamp):
        """Called by canopen for TPDO1; of a short one no value may be used."""
        if len(data) == 8:
            self.status = data[0]
            if data[0] & (ON | HAS_RELEASE | ERROR) == ON | HAS_RELEASE:
                self.good = time.monotonic()

    def start(self):
        """From wherever it is to its voltage."""
        while not self.news.empty():
            self.news.get()  # what comes from here on counts
        self.node.nmt.state = "PRE-OPERATIONAL"  # one that is stopped would not answer
        for sub, value in IDENTITY.items():
            if self.read(0x1018, sub, "<L") != value:
                raise ChargerError("another device than expected")
        self.write(*RELEASE, "<B", LOCKED)
        self.set(0x1017, 0, "<H", round(HEARTBEAT * 1000))
        self.set(0x2002, 0x01, "<H", round(CYCLE * 1000))
        self.set(0x2002, 0x04, "<H", round(RELEASE_FOR * 1000))
        self.set(0x2002, 0x08, "<H", VOLTS)
        self.set(0x2002, 0x09, "<H", MICROAMPERES)
        self.set(0x2002, 0x02, "<B", 1 << 3)  # CANopen may release, and nobody else
        self.make_operational()
        self.clear_errors()
        self.good = time.monotonic() + RAMP

    def clear_errors(self):
        """Those we know of, else the last one it has told; a reset clears one nobody has told."""
        self.status = self.read(*STATUS, "<B")
        if not self.status & ERROR:
            return
        _, kind, number = struct.unpack("<HBB", self.get(0x1003, 1, 4))
        known = self.uncleared or ({number} if kind == AN_ERROR else set())
        for each in sorted(known):
            self.write(*CLEAR_ERROR, "<B", each)
        self.status = self.read(*STATUS, "<B")
        if self.status & ERROR:
            if not self.uncleared:
                self.node.nmt.state = "RESET"  # one that nobody has told us the number of
            raise ChargerError(f"errors {sorted(known)} have a cause that lasts")

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
        raise ChargerError("it does not become operational")

    def watch(self, end):
        """Until then, or until something is wrong, with a release that is repeated."""
        poll = time.monotonic() + POLL
        while time.monotonic() < end:
            self.check()
            self.network.send_message(0x200 + NODE_ID, [RELEASED])
            if time.monotonic() >= poll:
                self.status = self.read(*STATUS, "<B")  # of a PDO that stands still, too
                poll = time.monotonic() + POLL
                self.check()
            try:
                raise ChargerError(self.news.get(timeout=RELEASE_EVERY))
            except queue.Empty:
                pass

    def check(self):
        """Whether it may stay released."""
        self.no_news()
        now = time.monotonic()
        if now - self.heard > LOST_AFTER or self.state != 5:
            raise ChargerError("no heartbeat, or one of a state that nobody commanded")
        if self.status & ERROR:
            raise ChargerError("an error that it has not told")
        if now - self.good > RAMP:
            raise ChargerError("no high voltage, or nobody who tells of it")

    def lock(self):
        """By PDO and by SDO; if neither gets through, the charger does it when its time is over."""
        self.network.send_message(0x200 + NODE_ID, [LOCKED])
        for _ in range(TRIES):
            try:
                self.node.sdo.download(*RELEASE, bytes([LOCKED]))
                if not self.node.sdo.upload(*STATUS)[0] & HAS_RELEASE:
                    return
            except SdoError as error:
                log.info("lock: %s", error)
            time.sleep(PAUSE)

    def set(self, index, sub, form, value):
        """Write a value, and see that it is there: canopen takes any confirmation for its own."""
        self.write(index, sub, form, value)
        if self.read(index, sub, form) != value:
            raise ChargerError(f"0x{index:04X}:{sub:02X} has not become {value}")

    def write(self, index, sub, form, value):
        """Send a value."""
        self.patiently(index, self.node.sdo.download, index, sub, struct.pack(form, value))

    def read(self, index, sub, form):
        """A number; one of another length is none."""
        return struct.unpack(form, self.get(index, sub, struct.calcsize(form)))[0]

    def get(self, index, sub, size):
        """So many bytes."""
        data = self.patiently(index, self.node.sdo.upload, index, sub)
        if len(data) != size:
            raise ChargerError(f"0x{index:04X}:{sub:02X} has {len(data)} bytes instead of {size}")
        return data

    def patiently(self, index, access, *arguments):
        """Several times if need be, but not while there is news that matters more."""
        for _ in range(TRIES):
            self.no_news()
            time.sleep(GAP)  # an answer that comes twice is in by then, and dropped by canopen
            try:
                return access(*arguments)
            except SdoError as error:
                log.info("0x%04X: %s", index, error)
            time.sleep(PAUSE)
        raise ChargerError(f"no access to 0x{index:04X}")

    def no_news(self):
        """Go on only if nothing has happened meanwhile."""
        if not self.news.empty():
            raise ChargerError(self.news.get())


def main(network, seconds=30.0):
    """Keep the voltage for so long; a charger that is lost is started again and again."""
    charger = Charger(network)
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        try:
            charger.start()
            charger.watch(end)
        except ChargerError as error:
            log.info("%s", error)
        charger.lock()
        time.sleep(SETTLE)
