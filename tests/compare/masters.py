"""What masters do with their devices: each exercises much of one, in a few simulated seconds."""

PAUSE = 0.004  # seconds
PATIENCE = 250  # pauses until an answer is given up


class Master:
    """Asks one node of a bench, and waits for its answers as a master does."""

    def __init__(self, bench, pause=PAUSE):
        self.bench = bench
        self.pause = pause
        self.node = bench.node_id
        self.boot_up = f"{0x700 + self.node:03X}#00"

    def send(self, base, data):
        return self.bench.send(f"{base + self.node if base >= 0x180 else base:03X}#{data}")

    def run(self, seconds):
        self.bench.run(seconds)

    def ask(self, data):
        """A request, and its answer; empty if there is none."""
        can_id = f"{0x580 + self.node:03X}#"
        answers = self.send(0x600, data)
        for _ in range(PATIENCE):
            found = [text[4:] for text in answers if text.startswith(can_id)]
            answers = self.bench.run(self.pause)
            if found:
                return found[0]
        return ""

    def read(self, *addresses):
        """SDO uploads, each followed through to its last segment."""
        for address in addresses:
            answer = self.ask(f"40{named(*address)}00000000")
            toggle = 0x60
            segmented = answer[:2] in ("41", "40")
            while segmented:
                answer = self.ask(f"{toggle:02X}00000000000000")
                toggle ^= 0x10
                segmented = answer != "" and not int(answer[:2], 16) & 0x81

    def write(self, index, subindex, value, size=2):
        """An expedited SDO download."""
        command = 0x23 | (4 - size) << 2
        data = (value % (1 << 8 * size)).to_bytes(4, "little").hex().upper()
        self.ask(f"{command:02X}{named(index, subindex)}{data}")

    def nmt(self, command):
        self.send(0, f"{command:02X}{self.node:02X}")

    def reset(self):
        """NMT reset node, until it has booted: at once, or later."""
        if self.boot_up not in self.send(0, f"81{self.node:02X}"):
            self.wait_for_boot_up()

    def wait_for_boot_up(self):
        for _ in range(1000):
            if self.boot_up in self.bench.run(PAUSE):
                return


def named(index, subindex):
    """An address as it stands in a frame."""
    return f"{index & 0xFF:02X}{index >> 8:02X}{subindex:02X}"


IDENTITY = [(0x1000, 0), (0x1008, 0), (0x1009, 0), (0x100A, 0), *((0x1018, n) for n in range(5))]
FIGURES = [(index, 0) for index in (0x2000, 0x2001, 0x2002, 0x2003)]
SET_VALUES = [(index, 0) for index in (0x2010, 0x2011, 0x2012, 0x2013, 0x2030, 0x2031)]
ACTUAL = [(index, 0) for index in (0x2020, 0x2021, 0x2022, 0x2023)]
SAVE = 0x65766173


def supply(bench, pause=PAUSE):
    """A TopCon: who it is, its figures, a run with an emergency, PDOs, guarding, a reset."""
    master = Master(bench, pause)
    if not bench.trace:
        master.wait_for_boot_up()
    master.run(0.05)
    master.read(*IDENTITY, *FIGURES, *SET_VALUES, (0x1003, 1), (0x2FFF, 0), (0x1018, 9))
    master.write(0x1017, 0, 100)
    master.write(0x2010, 0, 4100)
    master.write(0x2010, 0, 5)
    master.read((0x2010, 0))
    master.write(0x1400, 1, 0x206, size=4)
    master.write(0x1400, 1, 0x205, size=4)
    master.run(0.25)
    master.nmt(0x01)
    _run_it(master)
    _ask_for_pdos(master)
    _sync(master)
    _trip(master)
    _ask_for_pdos(master)
    _store(master)
    master.nmt(0x02)
    master.read((0x1000, 0))
    master.run(0.3)
    master.nmt(0x80)
    master.run(0.2)
    master.reset()
    master.run(1.1)
    master.read(*IDENTITY[:2], *SET_VALUES)


def measuring(bench):
    """A TopCon that runs: what it measures, asked for and in PDOs."""
    master = Master(bench)
    if not bench.trace:
        master.wait_for_boot_up()
    master.nmt(0x01)
    _run_it(master)
    _ask_for_pdos(master)


def too_high(bench):
    """A TopCon that is told to give more than its nominal voltage."""
    master = Master(bench)
    if not bench.trace:
        master.wait_for_boot_up()
    master.read(*IDENTITY, (0x2010, 0))
    master.write(0x2010, 0, 4100)
    master.read((0x2010, 0))


def _run_it(master):
    master.send(0x200, "D007")
    master.send(0x300, "E803")
    master.send(0x500, "0100")
    master.run(0.01)
    master.read(*ACTUAL)
    master.run(0.3)
    master.read(*ACTUAL)


def _ask_for_pdos(master):
    for _ in range(4):
        master.send(0x180, "R")
        master.run(0.02)
        master.send(0x700, "R")
        master.run(0.02)


def _sync(master):
    master.write(0x1800, 2, 1, size=1)
    for _ in range(5):
        master.send(0x80, "")
        master.run(0.05)
    master.write(0x1800, 2, 253, size=1)


def _trip(master):
    master.write(0x2030, 0, 1900)
    master.run(0.1)
    master.read((0x1001, 0), (0x1003, 0), (0x1003, 1), *ACTUAL)
    master.write(0x2014, 0, 1)
    master.read((0x2023, 0))
    master.write(0x2030, 0, 4400)
    master.write(0x2014, 0, 2)
    master.run(0.05)
    master.read((0x1001, 0), (0x2023, 0))
    master.write(0x2014, 0, 1)
    master.run(0.2)
    master.nmt(0x80)
    master.run(0.05)
    master.read(*ACTUAL)
    master.nmt(0x01)
    master.write(0x2014, 0, 0)
    master.write(0x2030, 0, 100)
    master.run(0.01)
    master.read((0x2023, 0))
    master.write(0x2030, 0, 4400)
    master.write(0x2014, 0, 2)


def _store(master):
    for _ in range(2):
        master.write(0x1010, 1, SAVE, size=4)
    master.read((0x1010, 1))


def charging(bench):
    """A charger: who it is, what it has behind it, high voltage and back, a reset."""
    master = Master(bench)
    if not bench.trace:
        master.wait_for_boot_up()
    master.read(*IDENTITY[:2], *IDENTITY[3:8], (0x1017, 0), (0x1003, 1), (0x2001, 5), (0x2000, 0xB))
    master.read(*((0x2000, sub) for sub in (2, 3, 6, 7)))
    master.write(0x1017, 0, 250)
    master.read((0x1017, 0))
    master.write(0x1017, 0, 500)
    master.write(0x1010, 1, 0x12345678, size=4)
    master.nmt(0x01)
    master.run(1.2)
    master.write(0x2002, 2, 8, size=1)  # CANopen may release
    master.write(0x2002, 8, 20_000)  # V
    master.send(0x200, "0F")
    master.run(3)
    master.read((0x2001, 1), (0x2001, 0xC), (0x6401, 1), (0x6401, 2))
    master.send(0x200, "00")
    master.write(0x2003, 1, 0x33, size=1)
    master.run(0.5)
    master.nmt(0x80)
    master.run(0.3)
    master.reset()
    master.run(1.2)
    master.read((0x1000, 0), (0x1017, 0))


def governing(bench):
    """A gateway: every object, and its TPDOs while the engine is at rest."""
    master = Master(bench)
    if not bench.trace:
        master.wait_for_boot_up()
    master.read(*((index, 0) for index in bench.remote.object_dictionary.indices if index > 0xFFF))
    master.nmt(0x01)
    master.run(1.0)
    master.read((0x1001, 0), (0x2000, 0), (0x2005, 0))
    master.reset()
    master.run(0.5)
