import pytest

from canopen_twins.bus.hub.protocol import HubAddress
from canopen_twins.errors import UserError

ADDRESSES = {
    "": ("127.0.0.1", 29536),
    ":5000": ("127.0.0.1", 5000),
    ":0": ("127.0.0.1", 0),
    "localhost": ("localhost", 29536),
    "0.0.0.0:29536": ("0.0.0.0", 29536),
    "hub.example:1": ("hub.example", 1),
    "[::1]:5000": ("::1", 5000),
    "[::1]": ("::1", 29536),
}


@pytest.mark.parametrize("text", ADDRESSES, ids=repr)
def test_an_address_is_read(text):
    assert HubAddress.parse(text) == ADDRESSES[text]


@pytest.mark.parametrize("text", ["127.0.0.1:", "a:b", "::1", "host:65536", "a:1:2", "[1]x"])
def test_what_is_no_address_is_refused(text):
    with pytest.raises(UserError, match=r"write HOST:PORT, such as 127\.0\.0\.1:29536"):
        HubAddress.parse(text)


@pytest.mark.parametrize(
    "address", [HubAddress(), HubAddress("::1", 5), HubAddress("hub", 1)], ids=str
)
def test_an_address_is_written_as_it_is_read(address):
    assert HubAddress.parse(str(address)) == address


def test_loopback_is_what_stays_on_the_machine():
    inside = ["127.0.0.1", "127.9.9.9", "::1", "localhost"]
    outside = ["0.0.0.0", "192.168.1.1", "::", "hub.example", "localhost.example"]
    assert all(HubAddress(host).is_loopback for host in inside)
    assert not any(HubAddress(host).is_loopback for host in outside)
