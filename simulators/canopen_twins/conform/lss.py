"""Topics about LSS: a slave is addressed by its identity, asked and configured."""

from canopen_twins.bus.identifiers import LSS_ANSWER, LSS_REQUEST
from canopen_twins.conform.tester import (
    RESET_COMMUNICATION,
    SILENCE,
    Failed,
    NotApplicable,
    Tester,
)
from canopen_twins.conform.topic import Group

LSS = Group(11, "LSS", "lss")

SWITCHING, INQUIRING = "CiA 305, 6.3", "CiA 305, 6.5"
CONFIGURING, IDENTIFYING = "CiA 305, 6.4", "CiA 305, 6.6"
LENGTH = 8
WAITING, CONFIGURATION = 0, 1
VENDOR, PRODUCT, REVISION, SERIAL = range(1, 5)
DONE, NOT_SUPPORTED, REFUSED = 0, 1, 1


def _request(tester: Tester, command: int, content: bytes = b"") -> None:
    tester.send(LSS_REQUEST, (bytes([command]) + content).ljust(8, b"\0"))


def _ask(tester: Tester, command: int, content: bytes = b"") -> bytes:
    """The answer, which begins with a command of its own or the same."""
    tester.forget()
    _request(tester, command, content)
    return tester.hear(LSS_ANSWER, length=LENGTH)


def _expect_silence(tester: Tester, what: str) -> None:
    tester.expect_silence(LSS_ANSWER, f"answers {what}")


def _identity(tester: Tester) -> list[int]:
    """The numbers of 0x1018; 0 for those that are not there.

    Raises:
        NotApplicable: the EDS says that there is no LSS.
    """
    if not tester.slave.dictionary.device_information.LSS_supported:
        raise NotApplicable("the EDS says LSS_Supported=0")
    return [
        tester.number(0x1018, sub) & 0xFFFFFFFF if tester.entry(0x1018, sub) is not None else 0
        for sub in (VENDOR, PRODUCT, REVISION, SERIAL)
    ]


def _select(tester: Tester, identity: list[int]) -> None:
    for command, number in zip(range(0x40, 0x44), identity, strict=True):
        _request(tester, command, number.to_bytes(4, "little"))


def _configuring(tester: Tester) -> list[int]:
    """Select the slave; its identity."""
    identity = _identity(tester)
    tester.forget()
    _select(tester, identity)
    if (answer := tester.hear(LSS_ANSWER, length=LENGTH))[0] != 0x44:
        raise Failed(f"{answer.hex()} instead of 44")
    return identity


@LSS.topic(SWITCHING)
def is_selected(tester: Tester) -> None:
    """A slave that is selected by its identity says so."""
    _configuring(tester)
    _request(tester, 0x04, bytes([WAITING]))


@LSS.topic(SWITCHING)
def is_not_selected_by_others(tester: Tester) -> None:
    """A slave with another serial number is silent, and not selected."""
    identity = _identity(tester)
    tester.forget()
    _select(tester, [*identity[:3], identity[3] ^ 1])
    _expect_silence(tester, "the identity of another")
    _request(tester, 0x5E)
    _expect_silence(tester, "though it is not selected")


@LSS.topic(SWITCHING)
def waits(tester: Tester) -> None:
    """A slave that waits does not answer to questions and orders."""
    _identity(tester)
    tester.forget()
    for command in (0x11, 0x13, 0x17, 0x5A, 0x5B, 0x5C, 0x5D, 0x5E):
        _request(tester, command, b"\1")
    _expect_silence(tester, "while it waits")


@LSS.topic(SWITCHING)
def is_switched_globally(tester: Tester) -> None:
    """A global switch to configuration is not answered, and acts; so does the way back."""
    _identity(tester)
    tester.forget()
    _request(tester, 0x04, bytes([CONFIGURATION]))
    _expect_silence(tester, "a global switch")
    _ask(tester, 0x5E)
    _request(tester, 0x04, bytes([WAITING]))
    _request(tester, 0x5E)
    _expect_silence(tester, "after the way back")


@LSS.topic(INQUIRING)
def tells_its_identity(tester: Tester) -> None:
    """The four numbers of the identity are those of 0x1018."""
    for command, number in zip(range(0x5A, 0x5E), _configuring(tester), strict=True):
        answer = _ask(tester, command)
        if answer[:5] != bytes([command]) + number.to_bytes(4, "little"):
            raise Failed(f"{answer.hex()} instead of {number:08X}h")
    _request(tester, 0x04, bytes([WAITING]))


@LSS.topic(INQUIRING)
def tells_its_node_id(tester: Tester) -> None:
    """The node id is told."""
    _configuring(tester)
    answer = _ask(tester, 0x5E)
    _request(tester, 0x04, bytes([WAITING]))
    if answer[:2] != bytes([0x5E, tester.slave.node_id]):
        raise Failed(f"{answer.hex()} instead of {tester.slave.node_id}")


@LSS.topic(CONFIGURING)
def refuses_node_ids(tester: Tester) -> None:
    """Node ids 0, 128 and 254 are refused: error code 1."""
    _configuring(tester)
    answers = [_ask(tester, 0x11, bytes([node_id]))[:2] for node_id in (0, 128, 254)]
    _request(tester, 0x04, bytes([WAITING]))
    if answers != [bytes([0x11, REFUSED])] * 3:
        raise Failed(f"{b' '.join(answers).hex()} instead of three times 1101")


@LSS.topic(CONFIGURING)
def takes_another_node_id(tester: Tester) -> None:
    """A node id acts with the next reset of the communication, and not before."""
    _configuring(tester)
    before = tester.slave.node_id
    other = 0x7C if before != 0x7C else 0x7B
    answer = _ask(tester, 0x11, bytes([other]))
    _request(tester, 0x04, bytes([WAITING]))
    if answer[:2] != bytes([0x11, DONE]):
        raise Failed(f"node id {other} is refused: {answer.hex()}")
    tester.read((0x1000, 0))
    tester.nmt(RESET_COMMUNICATION)
    try:
        tester.slave.node_id = other
        tester.hear(tester.error_control, 10.0)
    finally:
        tester.slave.node_id = other
        _give_back(tester, before)


def _give_back(tester: Tester, node_id: int) -> None:
    """The node id that it had."""
    _request(tester, 0x04, bytes([CONFIGURATION]))
    _request(tester, 0x11, bytes([node_id]))
    _request(tester, 0x04, bytes([WAITING]))
    tester.nmt(RESET_COMMUNICATION)
    tester.slave.node_id = node_id
    for _ in tester.listen(PAUSE):
        pass


PAUSE = 2.0  # seconds, for a boot


@LSS.topic(CONFIGURING)
def refuses_bit_timings(tester: Tester) -> None:
    """A bit timing of a table that does not exist is refused."""
    _configuring(tester)
    answer = _ask(tester, 0x13, bytes([0x7F, 0x7F]))
    _request(tester, 0x04, bytes([WAITING]))
    if answer[0] != 0x13 or answer[1] == DONE:
        raise Failed(f"{answer.hex()} to table 127")


@LSS.topic(CONFIGURING)
def stores(tester: Tester) -> None:
    """Storing is answered: done, or not supported."""
    _configuring(tester)
    answer = _ask(tester, 0x17)
    _request(tester, 0x04, bytes([WAITING]))
    if answer[0] != 0x17 or answer[1] not in (DONE, NOT_SUPPORTED):
        raise Failed(f"{answer.hex()} to a request to store")


def _identify(tester: Tester, numbers: list[int]) -> None:
    for command, number in zip(range(0x46, 0x4C), numbers, strict=True):
        _request(tester, command, number.to_bytes(4, "little"))


@LSS.topic(IDENTIFYING)
def is_identified(tester: Tester) -> None:
    """A slave within the ranges of an identification says so, and one outside is silent."""
    vendor, product, revision, serial = _identity(tester)
    tester.forget()
    _identify(tester, [vendor, product, revision, revision, serial, serial])
    if (answer := tester.hear(LSS_ANSWER, length=LENGTH))[0] != 0x4F:
        raise Failed(f"{answer.hex()} instead of 4f")
    tester.forget()
    _identify(tester, [vendor ^ 1, product, revision, revision, serial, serial])
    _expect_silence(tester, "the identification of another")


@LSS.topic(IDENTIFYING)
def is_configured(tester: Tester) -> None:
    """A slave with a node id answers neither to 4Ch nor to a fast scan."""
    _identity(tester)
    tester.forget()
    _request(tester, 0x4C)
    _request(tester, 0x51, bytes([0, 0, 0, 0, 0x80]))
    tester.expect_silence(LSS_ANSWER, "though it has a node id", SILENCE)


GROUPS = (LSS,)
