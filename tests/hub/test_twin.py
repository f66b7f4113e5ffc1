import signal
import socket
import time
from queue import SimpleQueue
from threading import Thread

import can
import canopen
import pytest

from canopen_twins.bus.hub.client import HubBus
from canopen_twins.bus.hub.protocol import HubAddress
from canopen_twins.cli import main
from canopen_twins.live.serve import LONGEST_GAP

from .conftest import EDS, PATIENCE, hub_at, started

pytestmark = pytest.mark.usefixtures("quick_to_disconnect")


@pytest.fixture
def master(stack):
    """A canopen master in this process, a TopCon and the hub in two others."""
    _, told = stack.enter_context(started("hub", "--listen", ":0"))
    address = HubAddress(told["host"], told["port"])
    twin = ("run", "topcon", "-n", "5", "--hub", str(address), "-c", "can7")
    _, ready = stack.enter_context(started(*twin))
    assert ready == {"ready": "topcon", "node_id": 5, "hub": str(address), "channel": "can7"}
    network = stack.enter_context(canopen.Network())
    network.connect(interface="socketcand", channel="can7", host=address.host, port=address.port)
    return network.add_node(5, EDS)


def test_a_master_in_another_process_finds_a_whole_slave(master):
    emergencies = SimpleQueue()
    master.emcy.add_callback(emergencies.put)
    assert master.sdo.upload(0x1018, 1)
    master.sdo[0x1017].raw = 20
    assert master.nmt.wait_for_heartbeat(PATIENCE) == "PRE-OPERATIONAL"
    master.nmt.state = "OPERATIONAL"
    master.nmt.wait_for_heartbeat(PATIENCE)
    assert master.nmt.state == "OPERATIONAL"

    master.tpdo.read()
    received = SimpleQueue()
    master.tpdo[1].add_callback(received.put)
    master.tpdo[1].remote_request()
    assert received.get(timeout=PATIENCE) is master.tpdo[1]

    master.sdo["Overvoltage level"].raw = 2000
    master.sdo["Voltage reference"].raw = 3000
    with pytest.raises(canopen.SdoAbortedError):
        master.sdo["Voltage reference"].raw = 5000
    master.sdo["Current reference"].raw = 4000
    master.sdo["Run command"].raw = 1
    assert emergencies.get(timeout=PATIENCE).code == 0x3300


def test_a_hub_says_when_it_is_ready_and_stops_when_it_is_told():
    for number, code in ((signal.SIGTERM, 0), (signal.SIGINT, 130)):
        with started("hub", "--listen", "127.0.0.1:0") as (process, ready):
            assert ready["ready"] == "hub"
            process.send_signal(number)
            assert process.wait(PATIENCE) == code
        assert process.err == ""


def test_a_hub_for_others_is_told_that_there_is_no_password():
    with started("hub", "--listen", "0.0.0.0:0") as (process, _):
        pass
    assert "whoever reaches 0.0.0.0:0 can read and write: there is no password" in process.err


def test_a_twin_is_back_when_the_hub_is(stack):
    with hub_at(HubAddress(port=0)) as address:
        _, _ = stack.enter_context(started("run", "topcon", "-n", "5", "--hub", str(address)))
    with hub_at(address), HubBus(address, "vcan0") as bus, canopen.Network(bus) as network:
        network.connect()
        node = network.add_node(5, EDS)
        node.sdo.RESPONSE_TIMEOUT, node.sdo.MAX_RETRIES = 0.1, 50
        assert node.sdo.upload(0x1000, 0)


def test_a_hub_that_takes_nothing_leaves_no_gap_in_the_time_of_a_twin(stack):
    listener = stack.enter_context(socket.create_server(("127.0.0.1", 0)))
    answers = Thread(target=lambda: stack.enter_context(accepted(listener)))
    answers.start()
    bus = stack.enter_context(HubBus(HubAddress(*listener.getsockname()), "vcan0"))
    answers.join()
    while send(bus):
        begun = time.monotonic()
    assert time.monotonic() - begun < LONGEST_GAP


def send(bus):
    """Whether it has been taken."""
    try:
        bus.send(can.Message(arbitration_id=0x705, data=bytes(8), is_extended_id=False))
    except TimeoutError:
        return False
    return True


def accepted(listener):
    """A connection on which all that a hub says at the beginning has been said."""
    connection, _ = listener.accept()
    connection.sendall(b"< hi >< ok >< ok >")
    return connection


WRONG = [
    (["run", "topcon", "--hub", ":1"], "no hub at 127.0.0.1:1, start one with `canopen-twin hub`"),
    (["run", "topcon", "--hub", "a:b"], "'a:b' is no address: write HOST:PORT"),
    (["run", "topcon", "--hub", "-i", "virtual"], "leave --interface out"),
    (["hub", "--listen", "here:there"], "'here:there' is no address"),
    (["hub", "--listen", "192.0.2.1:0"], "no hub at 192.0.2.1:0: "),
]


@pytest.mark.parametrize(("arguments", "told"), WRONG, ids=str)
def test_wrong_input_is_told_in_one_line(arguments, told, capsys, caplog):
    assert main(arguments) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert told in err
    assert err.count("\n") == 1


SOCKETCAND = {
    "< open vcan0 >": "< ok >",
    "< own 00000000000000000000000000000020 >": "< error unknown command >",
    "< rawmode >": "< ok >",
    "< echo >": "< echo >",
}


def test_a_socketcand_that_knows_nothing_of_owners_is_joined_all_the_same():
    def serve(server):
        connection, _ = server.accept()
        connection.sendall(b"< hi >")
        for said, answer in SOCKETCAND.items():
            heard = connection.recv(1000).decode()
            told.append(heard)
            assert heard == said
            connection.sendall(answer.encode())
        connection.close()

    told = []
    with socket.create_server(("127.0.0.1", 0)) as server:
        thread = Thread(target=serve, args=(server,))
        thread.start()
        with HubBus(HubAddress(port=server.getsockname()[1]), "vcan0", [5]):
            thread.join()
    assert told == [*SOCKETCAND]
