"""A master that holds a TopCon supply at a voltage, whatever happens to the supply and the bus."""

import logging
import queue
import struct
import time

import canopen
from canopen.sdo.exceptions import SdoError

NODE_ID = 5
VOLTS, AMPERES = 100.0, 25.0
VENDOR, NAME = 0x1C4, b"TopCon Quadro"
HEARTBEAT, LOST_AFTER = 0.5, 1.25  # seconds
POLL = 2.0  # seconds; an emergency is heard at once, this is for one that got lost
TIMEOUT, TRIES, PAUSE = 0.3, 3, 0.05  # of an SDO access
SETTLE, BOOTED_BY = 0.5, 4.0  # seconds before a new start, and between two resets
RUN_COMMAND, STATE_OF_OUTPUT = 0x2014, 0x2023
STOP, RUN, RESET = 0, 1, 2
ON, WARNING, ERROR = 1 << 0, 1 << 14, 1 << 15
log = logging.getLogger(__name__)


class SupplyError(Exception):
    """The supply is not as it should be: it has to be stopped, and started from the beginning."""


class Sdo:
    """A client that takes no answer but its own, and of that no value but a whole one."""

    def __init__(self, network, node_id):
        self.network, self.cob_id = network, 0x600 + node_id
        self.answers = queue.Queue()
        network.subscribe(0x580 + node_id, lambda _, data, __: self.answers.put(bytes(data)))

    def write(self, index, sub, data):
        self.ask(struct.pack("<BHB4s", 0x23 | 4 - len(data) << 2, index, sub, data), 0x60)

    def read(self, index, sub, size):
        """The bytes of an object, which has to have so many."""
        answer = self.ask(struct.pack("<BHB4x", 0x40, index, sub), 0x40)
        expedited = answer[4 : 8 - (answer[0] >> 2 & 3)]
        data = (
            expedited if answer[0] & 0x02 else self.segments(int.from_bytes(answer[4:], "little"))
        )
        if len(data) != size:
            raise canopen.SdoCommunicationError(f"{len(data)} bytes instead of {size}")
        return data

    def segments(self, size):
        data, toggle, last = b"", 0x00, False
        while not last:
            answer = self.ask(bytes([0x60 | toggle]) + bytes(7), 0x00)
            if answer[0] & 0x10 != toggle:
                raise self.aborted(0x05030000, "the toggle bit has not alternated")
            data += answer[1 : 8 - (answer[0] >> 1 & 7)]
            last, toggle = answer[0] & 0x01, toggle ^ 0x10
            if len(data) > size or (last and len(data) < size):
                raise self.aborted(0x06070010, "not as many bytes as announced")
        return data

    def ask(self, request, specifier):
        while not self.answers.empty():
            self.answers.get()  # late: nobody waits for it any more
        self.network.send_message(self.cob_id, request)
        end = time.monotonic() + TIMEOUT
        while (left := end - time.monotonic()) > 0:
            try:
                answer = self.answers.get(timeout=left)
            except queue.Empty:
                break
            of_segment = request[0] & 0xE0 == 0x60  # which does not say of which object it is
            if len(answer) != 8 or not (of_segment or answer[1:4] == request[1:4]):
                continue
            if answer[0] == 0x80:
                raise canopen.SdoAbortedError(int.from_bytes(answer[4:], "little"))
            if answer[0] & 0xE0 == specifier:
                return answer
        raise self.aborted(0x05040000, "no answer")

    def aborted(self, code, why):
        """Tell the server that a transfer is over; what to tell the caller."""
        self.network.send_message(self.cob_id, struct.pack("<B3xL", 0x80, code))
        return canopen.SdoCommunicationError(why)


class Supply:
    """One supply: how it is brought to its voltage, watched and stopped."""

    def __init__(self, network):
        self.node = network.add_node(NODE_ID)
        self.sdo = Sdo(network, NODE_ID)
        self.news = queue.Queue()  # of callbacks, which leave the work to the main thread
        self.heard, self.state, self.reset_at = time.monotonic(), None, -BOOTED_BY
        self.node.nmt.add_heartbeat_callback(self.on_heartbeat)
        self.node.emcy.add_callback(self.on_emergency)

    def on_heartbeat(self, state):
        last, self.heard, self.state = self.heard, time.monotonic(), state
        if self.heard - last > LOST_AFTER:  # the main thread may have been busy meanwhile
            self.news.put("it was not heard for too long")
        if state == 0:
            self.news.put("it has booted")

    def on_emergency(self, error):
        if error.code:  # else one is over
            self.news.put(error)

    def start(self):
        while not self.news.empty():
            self.news.get()  # what comes from here on counts
        self.heard = time.monotonic()
        self.node.nmt.state = "PRE-OPERATIONAL"  # one that is stopped would not answer
        if self.number(0x1018, 1, 4) != VENDOR or self.read(0x1008, 0, len(NAME)) != NAME:
            raise SupplyError("another device than expected")
        self.write(RUN_COMMAND, STOP)
        self.write(0x1017, round(HEARTBEAT * 1000))
        self.clear_errors()
        nominal_voltage, nominal_current = self.number(0x2000), self.number(0x2001)
        self.write(0x2010, round(VOLTS / nominal_voltage * 4000))
        self.write(0x2011, round(AMPERES / nominal_current * 4000))
        self.write(0x2012, 4000)
        self.write(0x2013, 0)
        self.make_operational()
        self.write(RUN_COMMAND, RUN)
        self.expect_output()

    def clear_errors(self):
        if self.number(STATE_OF_OUTPUT) & (ERROR | WARNING):
            self.write(RUN_COMMAND, RESET)
            self.write(RUN_COMMAND, STOP)
            if self.number(STATE_OF_OUTPUT) & ERROR:
                raise SupplyError("its error has a cause that lasts")

    def make_operational(self):
        for _ in range(TRIES):
            self.node.nmt.state = "OPERATIONAL"
            end, self.state = time.monotonic() + LOST_AFTER, None
            while time.monotonic() < end:
                self.no_news()
                if self.state == 5:
                    return
                time.sleep(PAUSE)
        raise SupplyError("it does not become operational")

    def expect_output(self):
        """Whether the command has been obeyed is for the state to say, not for its confirmation."""
        for _ in range(TRIES):
            if self.number(STATE_OF_OUTPUT) & (ON | ERROR) == ON:
                return
            time.sleep(PAUSE)
        raise SupplyError("its output is not on")

    def watch(self, end):
        poll = time.monotonic() + POLL
        while time.monotonic() < end:
            try:
                raise SupplyError(self.news.get(timeout=HEARTBEAT / 2))
            except queue.Empty:
                pass
            if time.monotonic() - self.heard > LOST_AFTER or self.state != 5:
                raise SupplyError("no heartbeat, or one of a state that nobody commanded")
            if time.monotonic() >= poll:
                self.expect_output()
                poll = time.monotonic() + POLL

    def stop(self):
        """Switch off by whatever gets through."""
        for _ in range(TRIES):
            try:
                self.sdo.write(RUN_COMMAND, 0, struct.pack("<H", STOP))
                if not self.sdo.read(STATE_OF_OUTPUT, 0, 2)[0] & ON:
                    return
            except SdoError as error:
                log.info("stop: %s", error)
            time.sleep(PAUSE)
        if time.monotonic() - self.reset_at > BOOTED_BY:  # one that boots would never be ready
            self.reset_at = time.monotonic()
            self.node.nmt.state = "RESET"  # which begins with the output off

    def settle(self):
        """Before a new start; who tells of an error meanwhile is stopped again."""
        end = time.monotonic() + SETTLE
        while (left := end - time.monotonic()) > 0:
            try:
                log.info("%s", self.news.get(timeout=left))
            except queue.Empty:
                return
            self.stop()

    def write(self, index, value, sub=0):
        """Set a number of 16 bits, and see that it is there."""
        data = struct.pack("<H", value)
        self.patiently(self.sdo.write, index, sub, data)
        if self.read(index, sub, 2) != data:
            raise SupplyError(f"0x{index:04X} has not become {value}")

    def number(self, index, sub=0, size=2):
        return int.from_bytes(self.read(index, sub, size), "little")

    def read(self, index, sub, size):
        return self.patiently(self.sdo.read, index, sub, size)

    def patiently(self, access, *arguments):
        """Several times if need be, but not while there is news that matters more."""
        for _ in range(TRIES):
            self.no_news()
            try:
                return access(*arguments)
            except SdoError as error:
                log.info("0x%04X: %s", arguments[0], error)
            time.sleep(PAUSE)
        raise SupplyError(f"no access to 0x{arguments[0]:04X}")

    def no_news(self):
        if not self.news.empty():
            raise SupplyError(self.news.get())


def main(network, seconds=30.0):
    """Hold the voltage for so long; a supply that is lost is started again and again."""
    supply = Supply(network)
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        try:
            supply.start()
            supply.watch(end)
        except SupplyError as error:
            log.info("%s", error)
        supply.stop()
        supply.settle()
