import pytest
from canopen import SdoAbortedError
from probe import Probe

from canopen_twins.bus.clock import Clock, Scope
from canopen_twins.bus.wire import Wire
from canopen_twins.slave.dictionary import dictionary
from canopen_twins.slave.object import Abort, Object, Rejected
from canopen_twins.slave.profile import Profile
from canopen_twins.slave.slave import Slave

BYTE, WORD, LIMITED, TEXT, DOMAIN = (
    (index, 0) for index in (0x2000, 0x2001, 0x2003, 0x2005, 0x2006)
)


def make(node_id=5, od=None, **profile):
    clock = Clock()
    od = od or dictionary(Probe.eds, node_id)
    return Slave(od, node_id, Wire(clock), Scope(clock), Profile(**profile))


@pytest.fixture
def slave():
    return make()


def write(slave, address, data):
    slave.write(slave.entry(*address), data)


def read(slave, address):
    return slave.entry(*address).read()


@pytest.mark.parametrize(
    ("address", "data"),
    [
        ((0x1014, 0), b"\x85\0\0\0"),
        ((0x1400, 1), b"\x05\x02\0\0"),
        ((0x2000, 0), b"\0"),
        ((0x2001, 0), b"\x34\x12"),
        ((0x2004, 0), bytes(4)),
        ((0x2005, 0), b"text"),
        ((0x2006, 0), b""),
        ((0x200A, 0), bytes(8)),
        ((0x200B, 0), b"\xfe\xff\xff"),
        ((0x200C, 0), b"\x01"),
    ],
)
def test_an_entry_begins_with_its_default_or_with_zeros(slave, address, data):
    assert read(slave, address) == data


def test_every_slave_has_a_dictionary_of_its_own():
    one, other = make(5), make(6)
    write(one, WORD, b"\1\0")
    assert (read(other, WORD), read(make(5), WORD)) == (b"\x34\x12", b"\x34\x12")
    assert (one.number(0x1014), other.number(0x1014)) == (0x85, 0x86)


@pytest.mark.parametrize(
    ("address", "code"),
    [
        ((0x2FFF, 0), Abort.NO_OBJECT),
        ((0x0005, 0), Abort.NO_OBJECT),  # a dummy for mappings, no object
        ((0x2000, 1), Abort.NO_SUBINDEX),  # of a plain variable
        ((0x200D, 2), Abort.NO_SUBINDEX),  # the gap of a record
        ((0x1003, 4), Abort.NO_SUBINDEX),  # beyond the end of an array
    ],
)
def test_what_the_dictionary_does_not_have_is_refused(slave, address, code):
    with pytest.raises(Rejected) as refusal:
        slave.entry(*address)
    assert refusal.value.code == code
    assert not slave.has(*address)


def test_what_is_written_is_read_back(slave):
    for address, data in ((WORD, b"\xcd\xab"), (TEXT, b"longer than before"), (DOMAIN, b"\0\xff")):
        write(slave, address, data)
        assert read(slave, address) == data


@pytest.mark.parametrize(
    ("address", "value"), [((0x200B, 0), -2), ((0x200C, 0), 1), ((0x1018, 4), 4)]
)
def test_a_number_is_read_by_its_type(slave, address, value):
    assert slave.number(*address) == value


@pytest.mark.parametrize(
    ("data", "code"),
    [(b"\1", Abort.TOO_SHORT), (b"\1\2\3", Abort.TOO_LONG), (b"", Abort.TOO_SHORT)],
)
def test_a_length_that_does_not_fit_is_refused(slave, data, code):
    with pytest.raises(Rejected) as refusal:
        write(slave, WORD, data)
    assert (refusal.value.code, read(slave, WORD)) == (code, b"\x34\x12")


def test_the_profile_says_which_codes_a_wrong_length_has():
    slave = make(too_long=Abort.LENGTH, too_short=Abort.HARDWARE)
    for data, code in ((b"\1", Abort.HARDWARE), (b"\1\2\3", Abort.LENGTH)):
        with pytest.raises(Rejected) as refusal:
            write(slave, WORD, data)
        assert refusal.value.code == code


@pytest.mark.parametrize(
    ("value", "code"), [(101, Abort.TOO_HIGH), (32767, Abort.TOO_HIGH), (-101, Abort.TOO_LOW)]
)
def test_the_limits_of_the_eds_hold_and_the_old_value_stays(slave, value, code):
    write(slave, LIMITED, (7).to_bytes(2, "little"))
    with pytest.raises(Rejected) as refusal:
        write(slave, LIMITED, value.to_bytes(2, "little", signed=True))
    assert (refusal.value.code, slave.number(*LIMITED)) == (code, 7)


@pytest.mark.parametrize(
    ("limit", "refused", "accepted"), [("min", 9, (10, 255)), ("max", 11, (0, 10))]
)
def test_a_device_may_set_one_limit_only(limit, refused, accepted):
    od = dictionary(Probe.eds, 5)
    setattr(od[0x2000], limit, 10)
    slave = make(od=od)
    for value in accepted:
        write(slave, BYTE, bytes([value]))
    with pytest.raises(Rejected):
        write(slave, BYTE, bytes([refused]))


def test_a_parameter_value_comes_before_the_default():
    od = dictionary(Probe.eds, 5)
    od[0x2001].value = 7
    assert make(od=od).number(0x2001) == 7


@pytest.mark.parametrize("value", [-100, 0, 100])
def test_the_limits_themselves_are_allowed(slave, value):
    write(slave, LIMITED, value.to_bytes(2, "little", signed=True))
    assert slave.number(*LIMITED) == value


def test_an_object_has_its_value_where_it_reads_it(slave):
    values = [3]
    slave.bind({WORD: Object(read=lambda: values[0])})
    write(slave, WORD, b"\1\0")
    assert read(slave, WORD) == b"\3\0"
    values[0] = 4
    assert read(slave, WORD) == b"\4\0"


def test_an_object_may_read_bytes_that_go_out_unchanged(slave):
    slave.bind({DOMAIN: Object(read=lambda: b"\1\2\3"), TEXT: Object(read=lambda: "a text")})
    assert (read(slave, DOMAIN), read(slave, TEXT)) == (b"\1\2\3", b"a text")


def test_a_written_value_acts_as_a_number_or_text_and_is_kept(slave):
    acts = []
    slave.bind({LIMITED: Object(write=acts.append), TEXT: Object(write=acts.append)})
    write(slave, LIMITED, b"\xff\xff")
    write(slave, TEXT, b"abc")
    assert acts == [-1, "abc"]
    assert (read(slave, LIMITED), read(slave, TEXT)) == (b"\xff\xff", b"abc")


def test_a_value_is_adjusted_before_it_acts_and_is_kept(slave):
    acts = []
    slave.bind({BYTE: Object(adjust=lambda value: value & 0xF0, write=acts.append)})
    write(slave, BYTE, b"\xab")
    assert (acts, read(slave, BYTE)) == ([0xA0], b"\xa0")


def test_a_refused_value_is_not_kept(slave):
    def refuse(value):
        raise Rejected("never", Abort.DEVICE_STATE)

    slave.bind({BYTE: Object(write=refuse)})
    with pytest.raises(Rejected, match="never"):
        write(slave, BYTE, b"\1")
    assert read(slave, BYTE) == b"\0"


def test_of_two_objects_on_one_entry_the_first_bound_refuses_first(slave):
    acts = []

    def refuse(value):
        raise Rejected("no")

    slave.bind({BYTE: Object(write=refuse)})
    slave.bind({BYTE: Object(write=acts.append)})
    with pytest.raises(Rejected):
        write(slave, BYTE, b"\1")
    assert acts == []


def test_an_object_for_an_entry_that_does_not_exist_is_a_bug(slave):
    with pytest.raises(KeyError):
        slave.bind({(0x2FFF, 0): Object()})


@pytest.mark.parametrize(
    ("address", "data", "changes"),
    [((0x1003, 0), b"\0", 1), ((0x1017, 0), b"\1\0", 1), ((0x2000, 0), b"\1", 0)],
)
def test_only_a_write_to_the_communication_area_changes_communication(
    slave, address, data, changes
):
    changed = []
    slave.on_communication_change = lambda: changed.append(True)
    write(slave, address, data)
    assert len(changed) == slave.changes == changes


def test_a_bug_in_an_object_is_no_answer_of_the_device(slave):
    slave.bind({BYTE: Object(read=lambda: {}["missing"], write=lambda value: {}["missing"])})
    with pytest.raises(KeyError):
        read(slave, BYTE)
    with pytest.raises(KeyError):
        write(slave, BYTE, b"\1")


def test_canopen_s_own_access_goes_the_same_way(slave):
    acts = []
    slave.bind({LIMITED: Object(write=acts.append)})
    slave.sdo["Limited"].raw = 5
    assert (slave.sdo["Limited"].raw, acts) == (5, [5])
    with pytest.raises(SdoAbortedError) as refusal:
        slave.set_data(*LIMITED, b"\xff\x7f")
    assert refusal.value.code == Abort.TOO_HIGH
    with pytest.raises(SdoAbortedError) as refusal:
        slave.get_data(0x2FFF, 0)
    assert refusal.value.code == Abort.NO_OBJECT


def test_the_memory_of_the_application_can_be_taken_over_and_no_more():
    before, slave = make(), make()
    write(before, BYTE, b"\1")
    write(before, WORD, b"\1\0")
    write(before, (0x1017, 0), b"\1\0")
    slave.keep_application(before)
    assert (read(slave, BYTE), read(slave, WORD)) == (b"\1", b"\1\0")
    assert read(slave, (0x1017, 0)) == b"\0\0"
    write(before, WORD, b"\2\0")
    assert read(slave, WORD) == b"\1\0"


def test_there_is_one_slave_on_a_wire():
    clock = Clock()
    wire = Wire(clock)
    for node_id in (5, 6):
        Slave(dictionary(Probe.eds, node_id), node_id, wire, Scope(clock))
    assert list(wire) == [6]


RELATIVE = """
[DeviceInfo]
[DeviceComissioning]
NodeID=3
[1014]
ParameterName=Plain
DataType=0x0007
AccessType=rw
DefaultValue= $nodeid + 0x80
ParameterValue=0x100+$NODEID
[2000]
ParameterName=Text
DataType=0x0009
AccessType=rw
DefaultValue=$NODEID
[2001]
ParameterName=No number
DataType=0x0007
AccessType=rw
DefaultValue=$NODEID+?
[2002]
ParameterName=Compact
ObjectType=0x8
DataType=0x0005
AccessType=rw
DefaultValue=$NODEID+1
CompactSubObj=2
[2002Name]
NrOfEntries=2
1=First
2=Second
"""


@pytest.mark.parametrize("node_id", [1, 127])
def test_the_node_id_is_put_in_wherever_canopen_puts_it_in(tmp_path, node_id):
    eds = tmp_path / "relative.dcf"
    eds.write_text(RELATIVE)
    od = dictionary(str(eds), node_id)
    assert (od.node_id, od[0x2000].default, od[0x2001].default) == (node_id, "$NODEID", None)
    assert (od[0x1014].default, od[0x1014].value) == (0x80 + node_id, 0x100 + node_id)
    assert [od[0x2002].subindices[sub].default for sub in (1, 2)] == [node_id + 1, node_id + 1]
    assert od[0x1014] is od["Plain"]


def test_a_file_is_imported_once_for_all_node_ids(tmp_path):
    eds = tmp_path / "gone.dcf"
    eds.write_text(RELATIVE)
    dictionary(str(eds), 1)
    eds.unlink()
    assert dictionary(str(eds), 2)[0x1014].default == 0x82


def test_what_is_done_to_a_dictionary_is_not_done_to_the_next():
    dictionary(Probe.eds, 5)[0x1014].default = 0
    assert dictionary(Probe.eds, 5)[0x1014].default == 0x85
