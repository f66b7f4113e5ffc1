from copy import deepcopy

import pytest
import yaml

from canopen_twins.devices.charger.messages import read_catalogue
from canopen_twins.devices.charger.model.messages import CAUSES, Catalogue, Message, Severity
from canopen_twins.errors import UserError

INJECTED_ONLY = {"hardware", "parameter_memory", "discharging_short"}


@pytest.fixture
def data(catalogue_data):
    return deepcopy(catalogue_data)


@pytest.mark.spec("C-034")
def test_the_shipped_catalogue_has_14_errors_and_15_warnings_and_calls_them_assumed(
    catalogue, catalogue_data
):
    kinds = [message.severity for message in catalogue]
    assert [kinds.count(kind) for kind in Severity] == [14, 15]
    assert catalogue_data["assumed"] is True


def test_the_shipped_catalogue_has_a_message_for_every_cause_and_no_other(catalogue):
    keys = {(message.severity, message.key) for message in catalogue if message.key}
    assert {key for _, key in keys - {(c.severity, c.key) for c in CAUSES}} == INJECTED_ONLY
    assert all(catalogue.keyed(cause.severity, cause.key) for cause in CAUSES)


def test_every_shipped_error_trips_and_every_message_says_when(catalogue, catalogue_data):
    assert all(message.trips for message in catalogue if message.severity is Severity.ERROR)
    assert all(row["when"] for name in ("errors", "warnings") for row in catalogue_data[name])


@pytest.mark.spec("C-032")
def test_register_bits_follow_the_class_of_the_code(catalogue):
    classes = {0x2: 1 << 1, 0x3: 1 << 2, 0x4: 1 << 3}
    for message in catalogue:
        assert message.register == 1 | classes.get(message.emcy >> 12, 0), message


def test_messages_are_found_by_number_and_by_key(catalogue):
    sparks = catalogue.numbered(Severity.ERROR, 7)
    assert sparks is catalogue.keyed(Severity.ERROR, "strong_sparks")
    assert catalogue.numbered(Severity.ERROR, 0x50) is None


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (lambda data: data.update(format="topcon"), "unknown format 'topcon'"),
        (lambda data: data.update(notes="x"), "unknown key 'notes'"),
        (lambda data: data.update(assumed="perhaps"), "'perhaps' is neither true nor false"),
        (lambda data: data.update(errors=7), "a list is wanted here"),
        (lambda data: data["errors"].append(7), "a key with a value is wanted here"),
        (lambda data: data["errors"][0].update(number=2), "two errors with the number 2"),
        (lambda data: data["errors"][0].update(key="hardware"), "the key 'hardware'"),
        (lambda data: data["errors"][0].update(number=0x51), "number 0x51 is not in 0x01..0x50"),
        (lambda data: data["warnings"][1].update(number=0x61), "number 0x61 is not in"),
        (lambda data: data["errors"][0].update(number=0), "number 0x00 is not in"),
        (lambda data: data["errors"][0].update(number="one"), "'one' is no number"),
        (lambda data: data["errors"][0].update(number=1.5), "1.5 is no whole number"),
        (lambda data: data["errors"][0].update(emcy=0xFFF), "emcy 0x0fff is not in"),
        (lambda data: data["errors"][0].update(register=4), "register 0x04 is no byte with bit 0"),
        (lambda data: data["errors"][0].update(register=0x101), "register 0x101 is no byte"),
        (lambda data: data["errors"][0].update(trips=1), "'1' is neither true nor false"),
        (lambda data: data["warnings"][0].update(trips=True), "a warning does not trip"),
        (lambda data: data["errors"][0].update(key=""), "empty; a key is a word"),
        (lambda data: data["errors"][0].update(colour=1), "unknown key 'colour'"),
        (lambda data: data["errors"][0].pop("emcy"), "'emcy' is missing"),
    ],
)
def test_a_wrong_catalogue_is_refused_in_one_line_that_says_where(data, tmp_path, change, told):
    change(data)
    path = tmp_path / "messages.yaml"
    path.write_text(yaml.safe_dump(data))
    with pytest.raises(UserError, match=rf"^{path}:\d+:\d+: [^\n]+$") as refusal:
        read_catalogue(path)
    assert told in str(refusal.value)


@pytest.mark.parametrize("text", ["[]", "text", ""])
def test_what_is_no_mapping_is_no_catalogue(text, tmp_path):
    path = tmp_path / "messages.yaml"
    path.write_text(text)
    with pytest.raises(UserError, match=r"messages.yaml:1:1: "):
        read_catalogue(path)


def test_messages_without_a_key_may_be_many():
    messages = [Message(Severity.WARNING, number, 0xFF00, 0x81) for number in (1, 2)]
    assert list(Catalogue(messages)) == messages
