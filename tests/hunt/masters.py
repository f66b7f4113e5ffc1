"""A contract, and masters that keep it or do not."""

CONTRACT = """\
version: 1
name: A supply is held at a voltage
node: {device: topcon, node_id: 5, settings: {load: resistor 4}}
duration: 4
recovers: {within: 3, when: {value: {Voltage reference: 2000, Run command: 1}}}
space: {faults: [sdo_silence, power_cycle, heartbeat_stopped]}
steps:
  - {at: 0, expect: {never: {write: {Voltage reference: {min: 2001}}}}}
"""

CAREFUL = """\
import time

import canopen

WANTED = {0x2010: 2000, 0x2014: 1}


def main(network):
    supply = network.add_node(5)
    supply.sdo.RESPONSE_TIMEOUT = 0.1
    while True:
        for index, value in WANTED.items():
            keep(supply, index, value)
        time.sleep(0.5)


def keep(supply, index, value):
    try:
        if supply.sdo.upload(index, 0) != value.to_bytes(2, "little"):
            supply.sdo.download(index, 0, value.to_bytes(2, "little"))
    except canopen.SdoCommunicationError:
        pass
"""

HASTY = CAREFUL.replace("    while True:\n", "    for _ in range(2):\n")
"""It does not look again after a second."""
BRITTLE = CAREFUL.replace("canopen.SdoCommunicationError", "canopen.SdoAbortedError")
"""A lost answer ends it."""
