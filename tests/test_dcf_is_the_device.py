"""The DCF of `canopen-twin eds` is a fresh device with the same settings, entry by entry."""

import re
from contextlib import suppress
from dataclasses import fields
from itertools import count
from math import isfinite
from typing import Literal, get_args, get_origin, get_type_hints

import canopen
import pytest

from canopen_twins import UserError, devices
from canopen_twins.bus.clock import Clock
from canopen_twins.device.dcf import dcf
from canopen_twins.device.node import Node, wait_for_boot
from canopen_twins.device.settings import about
from canopen_twins.devices.charger.model.types import TYPES, Variant
from canopen_twins.devices.topcon.unit_file import read_unit_types
from canopen_twins.files.shipped import od_file
from canopen_twins.slave.dictionary import dictionary
from canopen_twins.slave.object import Entry, Rejected, entries_of


def choices(name, kind, told):
    """The values of a setting that are worth a look: every word, both ends of a range."""
    if get_origin(kind) is Literal:
        return get_args(kind)
    if kind is bool:
        return (False, True)
    return [end for end in (told.low, told.high) if isfinite(end)]


def everything():
    """Every device as it is, at another node id, with every setting, and every type."""
    for device in devices.names():
        settings = devices.find(device).settings
        yield device, {}
        yield device, {"node_id": 42}
        types = get_type_hints(type(settings))
        for field in fields(settings):
            for value in choices(field.name, types[field.name], about(field)):
                yield device, {field.name: value}
    with od_file("topcon_units.yaml") as path:
        units = list(read_unit_types(path))
    for unit in units:
        yield "topcon", {"unit": unit}
    yield "topcon", {"firmware": "V4.10.00", "hardware_version": "V3.x"}
    yield "gateway", {"config": "gateway_plain.yaml"}
    for heartbeat in (500, 0):
        yield "charger", {"heartbeat_default_ms": heartbeat}
    for kind in TYPES:
        for variant in Variant:
            if variant.value:
                yield "charger", {"kind": kind, "variant": variant.value, "node_id": 5}


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    return tmp_path_factory.mktemp("dcf") / "device.dcf"


VERSIONS = count(1)  # of that file


def delivered(device, settings):
    """A fresh one that has booted, and its file; skips what cannot be like this."""
    try:
        node = Node(devices.create(device, **settings), Clock())
    except UserError as refusal:
        pytest.skip(str(refusal))
    node.power_on()
    if not wait_for_boot([node], node.clock.advance):
        pytest.skip("it does not boot like this, so it has no file")
    return node.slave, dcf(devices.create(device, **settings))


def said(od):
    """What the entries of a dictionary begin with, by their addresses."""
    return {
        (variable.index, variable.subindex): Entry(variable, {}).initial
        for item in od.values()
        if item.index >= 0x1000
        for variable in entries_of(item).values()
    }


def read(slave):
    """What there is to read."""
    found = {}
    for entry in (entry for subs in slave.entries.values() for entry in subs.values()):
        with suppress(Rejected):
            if entry.readable:
                found[entry.address] = entry.read()
    return found


@pytest.mark.parametrize(
    ("device", "settings"),
    list(everything()),
    ids=lambda each: re.sub(r"[{}': ]+", " ", str(each)).strip() or "delivered",
)
def test_every_entry_reads_what_the_file_says(path, device, settings):
    slave, text = delivered(device, settings)
    path.write_text(text, "ascii")
    ours = said(dictionary(str(path), slave.node_id, version=next(VERSIONS)))
    assert ours.keys() == {(index, sub) for index, subs in slave.entries.items() for sub in subs}
    assert read(slave) == {address: ours[address] for address in read(slave)}


@pytest.mark.parametrize("device", devices.names())
def test_canopen_reads_the_same(path, device):
    slave, text = delivered(device, {"node_id": 42})
    path.write_text(text, "ascii")
    theirs = said(canopen.import_od(str(path)))
    assert read(slave) == {address: theirs[address] for address in read(slave)}


@pytest.mark.parametrize("device", devices.names())
def test_it_has_all_that_strict_readers_want(device):
    slave, text = delivered(device, {"node_id": 42})
    names = re.findall(r"^\[(.+)\]$", text, re.MULTILINE)
    assert names[0] == "FileInfo"
    assert "\nLastEDS=" in text
    assert set(re.findall(r"Time=(.*)$", text, re.MULTILINE)) <= {"12:00AM", "12:00PM"}
    serial = slave.number(0x1018, 4)
    keys = text.partition("[DeviceComissioning]\n")[2].partition("\n\n")[0].splitlines()
    assert [key for key in keys if not key.startswith("NodeName=")] == [
        "NodeID=42",
        f"Baudrate={RATES[device]}",
        "NetNumber=0",
        "NetworkName=",
        "CANopenManager=0",
        f"LSS_SerialNumber=0x{serial:08X}",
    ]


RATES = {"charger": 125, "gateway": 125, "topcon": 500}  # as delivered
