"""XDD and XDC files (CiA 311): the same sections as an EDS file has, told in XML.

Tools differ in where they put what: type, access and default stand at the object, or only at the
parameter behind its `uniqueIDRef`.
"""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from xml.parsers import expat

from canopen_twins.errors import UserError
from canopen_twins.files.sections import LARGEST_FILE, Section, Sections
from canopen_twins.files.whole import read_plain

DEEPEST = 64  # elements within elements
TYPES = {
    "BOOL": 0x01, "SINT": 0x02, "INT": 0x03, "DINT": 0x04, "USINT": 0x05, "UINT": 0x06,
    "UDINT": 0x07, "REAL": 0x08, "STRING": 0x09, "BITSTRING": 0x0A, "WSTRING": 0x0B,
    "LREAL": 0x11, "LINT": 0x15, "ULINT": 0x1B, "BYTE": 0x05, "WORD": 0x06, "DWORD": 0x07,
    "LWORD": 0x1B, "CHAR": 0x02,
}  # fmt: skip
"""Elements of IEC 61131-3 for the data types of CiA 301."""
ACCESS = {
    "const": "const", "read": "ro", "write": "wo", "readWrite": "rw",
    "readWriteInput": "rwr", "readWriteOutput": "rww", "noAccess": "ro",
}  # fmt: skip
BY_MAPPING = {("rw", "RPDO"): "rww", ("rw", "TPDO"): "rwr"}
FEATURES = {
    "nrOfRxPDO": "NrOfRXPDO", "nrOfTxPDO": "NrOfTXPDO", "granularity": "Granularity",
    "groupMessaging": "GroupMessaging", "bootUpSlave": "SimpleBootUpSlave",
    "layerSettingServiceSlave": "LSS_Supported",
}  # fmt: skip
IDENTITY = {
    "vendorName": "VendorName", "vendorID": "VendorNumber",
    "productName": "ProductName", "productID": "ProductNumber",
}  # fmt: skip
RATE = re.compile(r"([0-9]+)")


@dataclass
class Element:
    """An element of the file; namespaces do not matter."""

    name: str
    line: int
    attributes: Mapping[str, str]
    children: list["Element"] = field(default_factory=list)
    text: str = ""

    def all(self, name: str) -> Iterator["Element"]:
        """Every element of a name below this one."""
        for child in self.children:
            if child.name == name:
                yield child
            yield from child.all(name)

    def first(self, name: str) -> "Element | None":
        """The first of them."""
        return next(self.all(name), None)


def read_xdd(path: Path) -> Sections:
    """Read a file.

    Raises:
        UserError: it cannot be read, is too large, or no XML without a document type.
    """
    content = read_plain(path, LARGEST_FILE)
    return _sections(_parsed(path, content))


def _parsed(path: Path, content: bytes) -> Element:
    root = Element("", 0, {})
    within = [root]
    parser = expat.ParserCreate()

    def start(name: str, attributes: dict[str, str]) -> None:
        if len(within) > DEEPEST:
            raise UserError(f"{path}:{parser.CurrentLineNumber}: more than {DEEPEST} levels")
        element = Element(_local(name), parser.CurrentLineNumber, attributes)
        within[-1].children.append(element)
        within.append(element)

    def end(_: str) -> None:
        within.pop()

    def data(text: str) -> None:
        within[-1].text += text

    def refuse(*_: object) -> None:
        raise UserError(f"{path}:{parser.CurrentLineNumber}: a document type is not read")

    parser.StartElementHandler, parser.EndElementHandler = start, end
    parser.CharacterDataHandler, parser.StartDoctypeDeclHandler = data, refuse
    try:
        parser.Parse(content, True)
    except expat.ExpatError as failure:
        words = expat.errors.messages[failure.code]
        raise UserError(f"{path}:{failure.lineno}: no XML: {words}") from failure
    return root


def _local(name: str) -> str:
    return name.rpartition(":")[2]


def _sections(root: Element) -> Sections:
    sections = Sections("")
    sections.put(_information(root))
    if dummies := root.first("dummyUsage"):
        entries = (dummy.attributes.get("entry", "") for dummy in dummies.all("dummy"))
        keys = dict(entry.split("=", 1) for entry in entries if "=" in entry)
        sections.put(Section.of("DummyUsage", dummies.line, keys))
    if commissioning := root.first("deviceCommissioning"):
        sections.put(_commissioning(commissioning))
    parameters = {each.attributes.get("uniqueID"): each for each in root.all("parameter")}
    for item in root.all("CANopenObject"):
        index = item.attributes.get("index", "")
        sections.put(_entry(index, item, parameters))
        for sub in item.all("CANopenSubObject"):
            name = f"{index}sub{sub.attributes.get('subIndex', '')}"
            sections.put(_entry(name, sub, parameters))
    return sections


def _information(root: Element) -> Section:
    keys = {}
    identity = root.first("DeviceIdentity")
    for name, key in IDENTITY.items():
        if identity is not None and (element := identity.first(name)) is not None:
            keys[key] = element.text.strip()
    features = root.first("CANopenGeneralFeatures")
    for name, key in FEATURES.items():
        if features is not None and name in features.attributes:
            keys[key] = features.attributes[name]
    for rate in root.all("supportedBaudRate"):
        if match := RATE.match(rate.attributes.get("value", "")):
            keys[f"BaudRate_{match[1]}"] = "1"
    line = 0 if identity is None else identity.line
    return Section.of("DeviceInfo", line, keys)


def _commissioning(told: Element) -> Section:
    keys = {"NodeID": told.attributes.get("nodeID", "")}
    keys["NodeName"] = told.attributes.get("nodeName", "")
    if match := RATE.match(told.attributes.get("actualBaudRate", "")):
        keys["Baudrate"] = match[1]
    return Section.of("DeviceComissioning", told.line, keys)


def _entry(name: str, item: Element, parameters: Mapping[str | None, Element]) -> Section:
    said = item.attributes
    parameter = parameters.get(said.get("uniqueIDRef")) if "uniqueIDRef" in said else None
    keys = _of_parameter(parameter) if parameter else {}
    for attribute, key in (
        ("name", "ParameterName"),
        ("objectType", "ObjectType"),
        ("accessType", "AccessType"),
        ("defaultValue", "DefaultValue"),
        ("actualValue", "ParameterValue"),
        ("denotation", "Denotation"),
        ("lowLimit", "LowLimit"),
        ("highLimit", "HighLimit"),
        ("objFlags", "ObjFlags"),
        ("subNumber", "SubNumber"),
    ):
        if said.get(attribute):
            keys[key] = said[attribute]
    if said.get("dataType"):
        keys["DataType"] = f"0x{said['dataType'].removeprefix('0x')}"
    mapping = said.get("PDOmapping", "no")
    keys["PDOMapping"] = "0" if mapping == "no" else "1"
    access = keys.get("AccessType", "")
    keys["AccessType"] = BY_MAPPING.get((access, mapping), access)
    return Section.of(name, item.line, keys)


def _of_parameter(parameter: Element) -> dict[str, str]:
    keys = {"AccessType": ACCESS.get(parameter.attributes.get("access", ""), "")}
    for child in parameter.children:
        if child.name in TYPES:
            keys["DataType"] = f"0x{TYPES[child.name]:04X}"
        for name, key in (("defaultValue", "DefaultValue"), ("actualValue", "ParameterValue")):
            if child.name == name and "value" in child.attributes:
                keys[key] = child.attributes["value"]
        if child.name == "denotation" and (label := child.first("label")) is not None:
            keys["Denotation"] = label.text.strip()
    return keys
