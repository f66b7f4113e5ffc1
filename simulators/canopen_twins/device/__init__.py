"""Everything that the author of a device needs, from one import; these names are stable."""

from canopen_twins.device.chart import Band, Chart, Curve, Mood
from canopen_twins.device.device import BitMessage, Device, EmcyMessage, Message
from canopen_twins.device.faults import Fault, Parameter, Weather
from canopen_twins.device.settings import NodeSettings, setting
from canopen_twins.slave.emcy import Emcy, Farewell
from canopen_twins.slave.memory import Memory
from canopen_twins.slave.object import Abort, Address, Object, Rejected, Value
from canopen_twins.slave.profile import Profile
from canopen_twins.slave.rpdo import Rpdo
from canopen_twins.slave.service import Service, State
from canopen_twins.slave.slave import Slave
from canopen_twins.slave.tpdo import Tpdo

__all__ = [
    "Abort",
    "Address",
    "Band",
    "BitMessage",
    "Chart",
    "Curve",
    "Device",
    "Emcy",
    "EmcyMessage",
    "Farewell",
    "Fault",
    "Memory",
    "Message",
    "Mood",
    "NodeSettings",
    "Object",
    "Parameter",
    "Profile",
    "Rejected",
    "Rpdo",
    "Service",
    "Slave",
    "State",
    "Tpdo",
    "Value",
    "Weather",
    "setting",
]
