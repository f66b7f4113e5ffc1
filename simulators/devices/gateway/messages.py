"""The errors of CANopen communication as the master is told of them: Table 2, 9.5."""

from collections.abc import Mapping

from simulators.devices.gateway.model.canopen_errors import NUMBERS, CanopenError
from simulators.messages import BitMessage

CANOPEN_ERRORS = (0x2005, 0x00)
TEXTS: Mapping[CanopenError, str] = {
    CanopenError.DC_RESET: "the governor was reset, the gateway was not",
    CanopenError.INIT: "the governor could not initialise its gateway",
    CanopenError.TIME_CTRL: "an RPDO is missing",
    CanopenError.DC_CAN_BUS: "bus error at the governor",
    CanopenError.DC_CAN_COMM: "the governor lost telegrams, or its gateway",
    CanopenError.GW_RESET: "the gateway was reset, the governor was not",
    CanopenError.HEARTBEAT: "the partner's heartbeat is missing",
    CanopenError.GW_CAN_BUS_1: "error of the bus to the governor",
    CanopenError.GW_CAN_COMM_1: "the gateway lost telegrams, or its governor",
    CanopenError.GW_CAN_BUS_2: "error of the CANopen bus",
    CanopenError.GW_CAN_COMM_2: "a CANopen buffer has overflowed",
}
MESSAGES: Mapping[str, BitMessage] = {
    str(number): BitMessage(TEXTS[error], CANOPEN_ERRORS, error.bit_length() - 1)
    for number, error in NUMBERS.items()
}
