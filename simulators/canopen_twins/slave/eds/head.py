"""What stands before the objects of a file: of the file, the device, a DCF's node, and dummies."""

import re
from typing import Any

from canopen.objectdictionary import ODVariable

from canopen_twins.bus.identifiers import UNCONFIGURED
from canopen_twins.files.sections import Section, Sections
from canopen_twins.slave.eds.eds import Eds
from canopen_twins.slave.object import DUMMY_TYPES

DUMMY = re.compile(r"Dummy([0-9A-Fa-f]{1,4})", re.IGNORECASE)
STANDARD_DUMMIES = range(1, 8)
BIT_RATES = (10, 20, 50, 125, 250, 500, 800, 1000)  # kbit/s
COMMISSIONING = ("DeviceComissioning", "DeviceCommissioning")
"""The standard spells it with one m, some tools as it should be."""
MOST_LINES = 10_000  # of a comment


def read_head(sections: Sections, eds: Eds) -> None:
    """Take all of it into what is known of the file; what cannot be used is a remark."""
    _read_file_information(sections, eds)
    _read_device_information(sections.section("DeviceInfo"), eds)
    for name in COMMISSIONING:
        if name in sections:
            _commission(sections[name], eds)
    _read_dummies(sections.section("DummyUsage"), "DummyUsage" in sections, eds)


def _read_file_information(sections: Sections, eds: Eds) -> None:
    dictionary = eds.dictionary
    comments = sections.section("Comments")
    lines = range(1, 1 + min(eds.count(comments, "Lines") or 0, MOST_LINES))
    dictionary.comments = "\n".join(comments.text(f"Line{line}") for line in lines)
    file = sections.section("FileInfo")
    if file:  # where canopen looks for it when it writes a file
        written = {field.key: field.text for field in file.values()}
        setattr(dictionary, "__edsFileInfo", written)


def _read_device_information(section: Section, eds: Eds) -> None:
    information: Any = eds.dictionary.device_information
    for rate in BIT_RATES:
        if eds.count(section, f"BaudRate_{rate}"):
            information.allowed_baudrates.add(rate * 1000)
    for key, name in (
        ("VendorName", "vendor_name"),
        ("ProductName", "product_name"),
        ("OrderCode", "order_code"),
    ):
        if key in section:
            setattr(information, name, section[key].text)
    for key, name in (
        ("VendorNumber", "vendor_number"),
        ("ProductNumber", "product_number"),
        ("RevisionNumber", "revision_number"),
        ("NrOfRXPDO", "nr_of_RXPDO"),
        ("NrOfTXPDO", "nr_of_TXPDO"),
    ):
        setattr(information, name, eds.count(section, key))
    for key, name in (
        ("SimpleBootUpMaster", "simple_boot_up_master"),
        ("SimpleBootUpSlave", "simple_boot_up_slave"),
        ("Granularity", "granularity"),
        ("DynamicChannelsSupported", "dynamic_channels_supported"),
        ("GroupMessaging", "group_messaging"),
        ("LSS_Supported", "LSS_supported"),
    ):
        number = eds.count(section, key)
        setattr(information, name, None if number is None else bool(number))


def _commission(section: Section, eds: Eds) -> None:
    node_id = eds.count(section, "NodeID")
    if node_id is not None and node_id != UNCONFIGURED and not 1 <= node_id <= 127:
        eds.remark(section, f"NodeID {node_id} is not in 1..127: ignored", section["NodeID"])
        node_id = None
    eds.node_id = node_id
    eds.node_name = section.text("NodeName")
    eds.dictionary.node_id = 0
    if rate := eds.count(section, "Baudrate"):
        eds.dictionary.bitrate = rate * 1000


def _read_dummies(section: Section, is_there: bool, eds: Eds) -> None:
    if not is_there:
        allowed = dict.fromkeys(STANDARD_DUMMIES, 1)
        eds.remark(section, "is not there: the types 1 to 7 may fill gaps of RPDOs")
    else:
        keys = {int(match[1], 16): key for key in section if (match := DUMMY.fullmatch(key))}
        allowed = {index: eds.count(section, key) or 0 for index, key in keys.items()}
    for index in sorted(index for index, is_allowed in allowed.items() if is_allowed):
        if index in DUMMY_TYPES:
            dummy = ODVariable(f"Dummy{index:04X}", index, 0)
            dummy.data_type = index
            dummy.access_type = "const"
            eds.dictionary.add_object(dummy)
