import pytest

from canopen_twins import devices
from canopen_twins.cli import main

RELEASE = "0x2002:02 bit 3 does not let CANopen release (A-46)"


@pytest.fixture
def said(capsys):
    """Ask in this process: the exit code and what was said on stdout and stderr."""

    def said(*arguments):
        code = main(["why", *arguments])
        return code, *capsys.readouterr()

    return said


def test_an_object_is_told_with_everything_that_is_known_of_it(said):
    assert said("topcon", "0x2010") == (
        0,
        "object   0x2010:00 Voltage reference\n"
        "type     INTEGER16\n"
        "access   rw, also by PDO\n"
        "limits   0..4000\n"
        "source   manual 7.3.5\n",
        "",
    )


@pytest.mark.parametrize(
    ("arguments", "limits"),
    [
        (("topcon", "0x2014"), "those of its type"),
        (("charger", "0x1017"), "at most 60000"),
        (("charger", "0x2003:01"), "1..80"),
        (("topcon", "0x2010", "--set", "set_value_range=4400"), "0..4400"),
    ],
)
def test_limits_are_those_of_the_device_as_it_is_set(said, arguments, limits):
    _, out, _ = said(*arguments)
    assert f"limits   {limits}\n" in out


ANSWERS = [
    (
        ("topcon", "Run command=7"),
        "refused with 0x06090030: no command 7: 0 stops, 1 runs, 2 resets",
    ),
    (("topcon", "0x2014=1"), "accepted"),
    (("topcon", "0x2010=0xFA1"), "refused with 0x06090031: 4001 is above 4000"),
    (("topcon", "0x1400:01=0x80000205"), "accepted"),
    (("topcon", "0x2000=1"), "refused with 0x06010002: read only"),
    (("topcon", "0x1008=a longer text"), "refused with 0x06010002: read only"),
    (("charger", "0x1017=150"), "refused with 0x06090030: 150 ms is no multiple of 100"),
    (("charger", "0x1017=50"), "refused with 0x06090032: 50 ms is below 100"),
    (("charger", "0x1017=200", "-n", "0x05"), "accepted"),
    (("charger", "0x2002:0D=1000"), "refused with 0x06090032: 1000 is below 1500 (0x2002:0C)"),
    (("charger", "0x2002:08=31000"), "refused with 0x06090031: 31000 is above 30000 (0x2002:0D)"),
    (
        ("charger", "0x2002:04=400"),
        "accepted, without effect: below 500 ms it is kept as 0, which is no time-out",
    ),
    (("charger", "0x6200:01=0x0F"), f"accepted, without effect: {RELEASE}"),
    (("gateway", "0x1017=100"), "refused with 0x06010002: read only"),
]


@pytest.mark.parametrize(("arguments", "answer"), ANSWERS, ids=str)
def test_a_value_is_tried_after_the_boot_up_and_in_operational(said, arguments, answer):
    value = arguments[1].partition("=")[2]
    code, out, err = said(*arguments)
    assert (code, err) == (0, "")
    assert out.splitlines()[-2:] == [
        f"{value} after boot-up: {answer}",
        f"{value} in operational: {answer}",
    ]


def test_settings_count(said):
    _, before, _ = said("charger", "0x1017=150")
    _, after, _ = said("charger", "0x1017=150", "--set", "heartbeat_step=floor")
    assert "refused" in before
    assert after.count("accepted") == 2


def test_what_depends_on_the_state_is_told_apart(said):
    _, out, _ = said("topcon", "0x1800:01=0x40000185")
    assert "refused" in out
    _, out, _ = said("charger", "0x2002:06=5")
    assert out.count("without effect: it acts after it is saved by 0x1010") == 2


WRONG = [
    (("topkon", "0x2014"), "unknown device 'topkon': did you mean 'topcon'?"),
    (("topcon", "0x2015"), "unknown object '0x2015': did you mean '0x20"),
    (("topcon", "Run comand=1"), "unknown object 'Run comand': did you mean 'Run command'?"),
    (("topcon", "0x1018=1"), "0x1018 is a record: say which entry of it, such as 0x1018:01"),
    (("topcon", "0xyz"), "'0xyz' is no address"),
    (("topcon", "0x2014=many"), "object 'Run command' wants a whole number, not 'many'"),
    (("topcon", "0x2014="), "object 'Run command' wants a whole number, not ''"),
    (("topcon", "0x2014=65536"), "65536 does not fit UNSIGNED16"),
    (("topcon", "0x2014=-1"), "-1 does not fit UNSIGNED16"),
    (("topcon", "0x2014=1", "--set", "laod=1"), "unknown setting 'laod': did you mean 'load'?"),
    (("topcon", "0x2014=1", "-n", "200"), "node id 200 is not in 1..127"),
    (("gateway", "0x2005=1", "--set", "boot_time=1000"), "it does not boot: its CANopen state"),
]


@pytest.mark.parametrize(("arguments", "told"), WRONG, ids=str)
def test_nonsense_is_refused_in_one_line(said, arguments, told):
    code, out, err = said(*arguments)
    assert (code, out) == (2, "")
    assert err.startswith(f"canopen-twin: {told}")
    assert err.count("\n") == 1


@pytest.mark.parametrize("device", ["charger", "gateway", "topcon"])
def test_every_entry_of_every_device_can_be_asked_about(said, device):
    od = devices.create(device).dictionary()
    entries = [item for item in od.values() if item.index >= 0x1000]
    for item in entries[:: max(len(entries) // 12, 1)]:
        sub = min(getattr(item, "subindices", [0]))
        code, out, _ = said(device, f"0x{item.index:04X}:{sub:02X}")
        assert code == 0
        assert "source   none" not in out
