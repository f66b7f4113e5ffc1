"""Every setting and fault that a trace can show is found, and named by its object or service."""

from dataclasses import fields

import pytest

from canopen_twins import devices
from canopen_twins.faults import LEVELS

from .conftest import compared, told, traced
from .masters import charging, governing, supply

SETTINGS = [
    ({"timing": "typical"}, "TPDO1 0x2022:00 Actual power: another value"),
    ({"timing": "worst"}, "boot-up: another time"),
    ({"boot_time": 0.5}, "boot-up: another time"),
    ({"answer_time": 0.02}, "SDO answer time: another time"),
    ({"answer_jitter": 0.03}, "SDO answer time: another time"),
    ({"store_time": 0.3}, "Storage command: another time"),
    ({"store_time": 0.3, "store_busy": "refuses"}, "Storage command: refused by one, not by the"),
    ({"measure_time": 0.3}, "SDO 0x2020:00 Actual voltage: another value"),
    ({"noise": 3}, "TPDO1 0x2021:00 Actual current: another value"),
    ({"noise": 3, "seed": 5}, "TPDO1 0x2021:00 Actual current: another value"),
    ({"hb_first": "now"}, "heartbeat: only the device sends it"),
    ({"empty_1003": "abort"}, "Pre-defined Error Field 1: refused by one, not by the other"),
    ({"strict_cobid": "true"}, "COB-ID RPDO1: refused by one, not by the other"),
    ({"unit": "TCP-16-100"}, "SDO 0x2000:00 Nominal voltage: another value"),
    ({"hardware_version": "V5"}, "SDO 0x1009:00 Manufacturer Hardware Version: another value"),
    ({"firmware": "V4.11.20"}, "SDO 0x100A:00 Manufacturer Software Version: another value"),
    ({"serial": 7}, "SDO 0x1018:04 Identity Object.Serial number: another value"),
    ({"ready_time": 2.0}, "SDO 0x2023:00 State of output: another value"),
    ({"load": "resistor 4"}, "SDO 0x2021:00 Actual current: another value"),
    ({"ambient": 90}, "SDO 0x2023:00 State of output: another value"),
    ({"power_on_voltage": 5}, "SDO 0x2010:00 Voltage reference: another value"),
    ({"power_on_current": 5}, "SDO 0x2011:00 Current reference: another value"),
    ({"power_on_power": 5}, "SDO 0x2012:00 Power reference: another value"),
    ({"power_on_resistance": 5}, "SDO 0x2013:00 Internal resistance reference: another value"),
    ({"power_on_overvoltage": 4000}, "SDO 0x2030:00 Overvoltage level: another value"),
    ({"power_on_overcurrent": 4000}, "SDO 0x2031:00 Overcurrent level: another value"),
    ({"set_value_range": 32767}, "SDO 0x2010:00 Voltage reference: refused by one, not by the"),
    ({"run_while_error": "abort"}, "SDO 0x2014:00 Run command: refused by one, not by the other"),
    ({"on_leave_operational": "stop"}, "SDO 0x2020:00 Actual voltage: another value"),
    ({"ovp_when_off": "false"}, "EMCY: only the twin sends it"),
    ({"live": {"panel": "local"}}, "SDO 0x2010:00 Voltage reference: another value"),
    (
        {"live": {"panel": "local"}, "local_write": "abort"},
        "SDO 0x2010:00 Voltage reference: refused by one, not by the other",
    ),
]
NOT_SHOWN = {
    "busy_request": "a master that waits for its answers does not exercise it",
    "node_id": "it says which frames are the device's",
    "ah": "a node id by switches",
    "al": "a node id by switches",
    "br": "a trace has no bit rate",
    "quiet_time": "RS-232 is not on the bus",
    "unit_file": "names other units",
    "units": "the figures of several are those of one",
    "connection": "the figures of several are those of one",
    "cooldown": "takes heat, and minutes",
    "on_remote": "takes somebody at the panel while the trace goes on",
}

AT_TPDO = {"frame": "185#*"}
FAULTS = [
    ("interlock_open", {}, "EMCY: only the device sends it"),
    ("sense_reversed", {}, "EMCY: only the device sends it"),
    ("warning", {}, "SDO 0x2023:00 State of output: another value"),
    ("sdo_abort", {}, "SDO 0x1000:00 Device Type: refused by one, not by the other"),
    ("sdo_silence", {"times": 3}, "SDO 0x1000:00 Device Type: only the twin sends it"),
    ("sdo_late", {"seconds": 0.1}, "SDO answer time: another time"),
    ("sdo_wrong_index", {}, "SDO 0x1000:00 Device Type: another form"),
    ("sdo_wrong_toggle", {}, "SDO 0x1008:00 Manufacturer Device Name: another form"),
    ("sdo_wrong_size", {}, "SDO 0x1000:00 Device Type: another value"),
    ("sdo_stall", {}, "SDO 0x1008:00 Manufacturer Device Name: only the twin sends it"),
    ("sdo_in_wrong_state", {}, "SDO 0x1000:00 Device Type: only the device sends it"),
    ("pdo_frozen", {}, "TPDO1 0x2023:00 State of output: another value"),
    ("pdo_missing", {}, "TPDO1: only the twin sends it"),
    ("pdo_short", {}, "TPDO1: another form"),
    ("pdo_wrong_cob_id", {}, "TPDO1: only the twin sends it"),
    ("pdo_jitter", {}, "TPDO1: another time"),
    ("emcy_storm", {"times": 5}, "EMCY: only the device sends it"),
    ("emcy_lost", {}, "EMCY: only the twin sends it"),
    ("emcy_doubled", {}, "EMCY: only the device sends it"),
    ("heartbeat_stopped", {}, "heartbeat: only the twin sends it"),
    ("heartbeat_late", {}, "heartbeat: another time"),
    ("heartbeat_jitter", {}, "heartbeat: another time"),
    ("heartbeat_wrong_state", {}, "heartbeat: another value"),
    ("boot_up_lost", {}, "boot-up: only the twin sends it"),
    ("boot_up_repeated", {}, "boot-up: only the device sends it"),
    ("reset_loop", {}, "boot-up: only the device sends it"),
    ("power_cycle", {"seconds": 0.2}, "boot-up: only the device sends it"),
    ("brown_out", {}, "boot-up: only the device sends it"),
    ("duplicate_node_id", {}, "boot-up: only the device sends it"),
    ("wrong_identity", {}, "SDO 0x1018:02 Identity Object.Device description: another value"),
    ("wrong_firmware", {}, "SDO 0x100A:00 Manufacturer Software Version: another"),
    ("bus_off", {"seconds": 0.5}, "SDO 0x1000:00 Device Type: only the twin sends it"),
    ("error_passive", {"seconds": 0.05}, "SDO answer time: another time"),
    ("frame_lost", AT_TPDO, "TPDO1: only the twin sends it"),
    ("frame_doubled", AT_TPDO, "TPDO1: only the device sends it"),
    ("frame_late", AT_TPDO, "TPDO1: another time"),
    ("frame_jitter", AT_TPDO, "TPDO1: another time"),
    ("frame_swapped", AT_TPDO, "TPDO1: another time"),
    ("frame_corrupt", AT_TPDO, "TPDO1 0x2022:00 Actual power: another value"),
]
OF_OTHERS = {"bus_load"}  # frames that no device of the comparison has sent


CHARGERS = [
    ({"kind": "PCMT"}, "SDO 0x1008:00 Manufacturer device name: another value"),
    ({"variant": "A"}, "SDO 0x2000:0B: refused by one, not by the other"),
    ({"firmware": "0200"}, "SDO 0x100A:00 Manufacturer software version: another value"),
    ({"revision": 2}, "SDO 0x1018:03 Identity Object.Revision Number: another value"),
    ({"load": "resistor 1000000"}, "TPDO1 0x6000:03 Read Input 8 Bit.Read Charging Current Cap"),
    ({"ambient": 60}, "SDO 0x2001:05 Read Actual Values.Read Temperature Power Stage: another"),
    ({"charging_hours": 100.0}, "SDO 0x2000:06 Read Operating Hours.Read Charging Hours Days"),
    ({"heartbeat_default_ms": 2000}, "SDO 0x1017:00 Producer Heartbeat time: another value"),
    ({"heartbeat_step": "floor"}, "Producer Heartbeat time: refused by one, not by the other"),
    ({"tpdo3_without_discharge": "off"}, "TPDO3: only the twin sends it"),
    ({"tpdo_on_change": True}, "TPDO2: only the device sends it"),
    ({"signature": "any"}, "Save all Parameters: refused by one, not by the other"),
    ({"noise": 4}, "TPDO2 0x6401:01 Read Analog Input 16 Bit.Read Voltage Charging: another"),
    ({"faults": [("open_electrode", {})]}, "TPDO1 0x6000:03 Read Input 8 Bit.Read Charging Curr"),
    ({"faults": [("hardware_release_lost", {})]}, "0x6000:01 Read Input 8 Bit.Read System Stat"),
    ({"faults": [("memory_failure", {})]}, "EMCY: only the device sends it"),
]
GATEWAYS = [
    ({"first_tpdo": "never"}, "TPDO2: only the twin sends it"),
    ({"answer_time": 0.02}, "SDO answer time: another time"),
    ({"faults": [("governor_late", {})]}, "SDO 0x2005:00 CanOpen Errors: another value"),
    ({"faults": [("supply", {})]}, "SDO 0x1001:00 Error Register: another value"),
]


@pytest.mark.parametrize(("altered", "words"), CHARGERS, ids=str)
def test_an_altered_charger_is_found(altered, words):
    lines = told(compared(traced(charging, "charger", **altered), "charger"))
    assert any(words in line for line in lines), lines


@pytest.mark.parametrize(("altered", "words"), GATEWAYS, ids=str)
def test_an_altered_gateway_is_found(altered, words):
    lines = told(compared(traced(governing, "gateway", **altered), "gateway"))
    assert any(words in line for line in lines), lines


@pytest.mark.parametrize(
    ("device", "master", "settings"),
    [
        ("charger", charging, {}),
        ("charger", charging, {"timing": "typical", "variant": "A"}),
        ("gateway", governing, {}),
        ("gateway", governing, {"timing": "typical"}),
    ],
)
def test_one_that_is_not_altered_agrees(device, master, settings):
    agreement = compared(traced(master, device, **settings), device, **settings)
    assert (told(agreement), agreement.share) == ([], 1.0)


@pytest.mark.parametrize(("settings", "words"), SETTINGS, ids=str)
def test_a_setting_is_found(settings, words):
    lines = told(compared(traced(supply, **settings)))
    assert any(words in line for line in lines), lines


@pytest.mark.parametrize(("name", "parameters", "words"), FAULTS)
def test_a_fault_is_found(name, parameters, words):
    lines = told(compared(traced(supply, faults=[(name, parameters)])))
    assert any(words in line for line in lines), lines


def test_every_setting_is_looked_for_unless_there_is_a_reason():
    looked_for = {name for settings, _ in SETTINGS for name in settings} | {"panel"}
    every = {field.name for field in fields(devices.create("topcon").settings)}
    assert every - looked_for == set(NOT_SHOWN)


def test_every_fault_around_a_device_is_looked_for():
    every = {name for level in LEVELS.values() for name in level}
    assert every - {name for name, *_ in FAULTS} == OF_OTHERS


def test_there_are_as_many_as_there_have_to_be():
    assert len(SETTINGS) + len(FAULTS) > 60
