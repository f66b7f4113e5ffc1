"""A master that charges, in whatever time it lives in."""

import time

import canopen


def charge(eds, seconds, gives_up, **bus):
    """Switch on for some seconds; `gives_up`: and off, at the first emergency at once."""
    network = canopen.Network()
    network.connect(**bus)
    supply = network.add_node(5, eds)
    errors = []
    supply.emcy.add_callback(errors.append)
    while not _answers(supply):
        time.sleep(0.05)
    supply.nmt.state = "OPERATIONAL"
    supply.sdo["Voltage reference"].raw = 2000
    supply.sdo["Current reference"].raw = 4000
    supply.sdo["Run command"].raw = 1
    end = time.monotonic() + seconds
    while time.monotonic() < end and not (errors and gives_up):
        time.sleep(0.02)
    if gives_up:
        supply.sdo["Run command"].raw = 0
    network.disconnect()


def _answers(supply):
    try:
        supply.sdo.upload(0x1000, 0)
    except canopen.SdoCommunicationError:
        return False
    return True
