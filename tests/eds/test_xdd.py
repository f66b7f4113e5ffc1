"""XDD and XDC files come in by the same door as EDS files."""

import pytest

from canopen_twins import Bench
from canopen_twins.cli import main
from canopen_twins.errors import UserError
from canopen_twins.slave.eds.reader import read_eds

from .conftest import Reading

HEAD = """<?xml version="1.0" encoding="utf-8"?>
<dev:ISO15745ProfileContainer xmlns:dev="http://www.canopen.org/xml/1.1">
  <dev:ISO15745Profile><dev:ProfileBody>
    <dev:DeviceIdentity>
      <dev:vendorName>nobody</dev:vendorName><dev:vendorID>0x123</dev:vendorID>
    </dev:DeviceIdentity>
    <dev:ApplicationProcess><dev:parameterList>
      <dev:parameter uniqueID="p1" access="readWrite">
        <dev:UINT/><dev:defaultValue value="7"/>
      </dev:parameter>
    </dev:parameterList></dev:ApplicationProcess>
  </dev:ProfileBody></dev:ISO15745Profile>
  <dev:ISO15745Profile><dev:ProfileBody>
    <dev:ApplicationLayers>
      <dev:CANopenObjectList>
        <dev:CANopenObject index="1000" name="Device type" objectType="7" dataType="0007"
                           accessType="ro" defaultValue="0x191"/>
        <dev:CANopenObject index="1A00" name="Mapping" objectType="9" subNumber="2">
          <dev:CANopenSubObject subIndex="00" name="Count" objectType="7" dataType="0005"
                                accessType="rw" defaultValue="1"/>
          <dev:CANopenSubObject subIndex="01" name="First" objectType="7" dataType="0007"
                                accessType="rw" defaultValue="0x20000010"/>
        </dev:CANopenObject>
        <dev:CANopenObject index="2000" name="Set value" objectType="7" uniqueIDRef="p1"
                           PDOmapping="RPDO"/>
      </dev:CANopenObjectList>
      <dev:dummyUsage><dev:dummy entry="Dummy0005=1"/></dev:dummyUsage>
    </dev:ApplicationLayers>
    <dev:TransportLayers><dev:PhysicalLayer><dev:baudRate>
      <dev:supportedBaudRate value="500 Kbps"/>
    </dev:baudRate></dev:PhysicalLayer></dev:TransportLayers>
    <dev:NetworkManagement>
      <dev:CANopenGeneralFeatures layerSettingServiceSlave="true" nrOfTxPDO="1"/>
      <dev:deviceCommissioning nodeID="16" nodeName="sixteen" actualBaudRate="500 Kbps"/>
    </dev:NetworkManagement>
  </dev:ProfileBody></dev:ISO15745Profile>
</dev:ISO15745ProfileContainer>
"""


@pytest.fixture
def xdd(tmp_path):
    def make(text=HEAD):
        path = tmp_path / "drive.xdd"
        path.write_text(text, "utf-8")
        return path

    return make


def test_objects_and_what_stands_at_their_parameters(xdd):
    found = Reading(xdd())
    assert found.value(0x1000) == 0x191
    assert [found.value(0x1A00, sub) for sub in (0, 1)] == [1, 0x20000010]
    assert found.value(0x2000) == 7
    variable = found[0x2000, 0]
    assert (variable.data_type, variable.access_type, variable.pdo_mappable) == (6, "rww", True)


def test_what_a_configuration_says_of_the_node(xdd):
    eds = Reading(xdd()).eds
    assert (eds.node_id, eds.node_name, eds.dictionary.bitrate) == (16, "sixteen", 500_000)
    information = eds.dictionary.device_information
    assert information.allowed_baudrates == {500_000}
    assert information.vendor_number == 0x123
    assert information.LSS_supported
    assert 5 in eds.dictionary.indices  # the dummy


def test_it_is_a_twin_and_its_dcf_is_another(xdd, tmp_path, capsysbinary):
    bench = Bench(xdd())
    assert bench.sent == ["710#00"]
    assert bench.send("610#4000200000000000") == ["590#4B00200007000000"]
    assert main(["eds", str(xdd()), "--set", "node_id=16"]) == 0
    dcf = tmp_path / "drive.dcf"
    dcf.write_bytes(capsysbinary.readouterr().out)
    assert Bench(dcf).values() == bench.values()


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("<a", "drive.xdd:1: no XML: unclosed token"),
        ("<!DOCTYPE a [<!ENTITY b 'c'>]><a/>", "drive.xdd:1: a document type is not read"),
        ("<a/>", "drive.xdd is no EDS file: it has no object, such as [1000]"),
        ("<a>" * 99, "drive.xdd:1: more than 64 levels"),
    ],
)
def test_what_is_no_dictionary_is_refused_in_one_line(xdd, text, told):
    with pytest.raises(UserError) as refusal:
        read_eds(xdd(text))
    assert str(refusal.value).endswith(told)
