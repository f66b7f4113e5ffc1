import pytest

from .conftest import log, traced
from .local_node import BLOCK
from .masters import Master, supply

TRACE = """\
(1436509052.000000) can0 705#00
(1436509052.100000) can0 605#4000200000000000
(1436509052.101000) can0 585#4B00200090010000
(1436509052.200000) can0 706#7F
(1436509052.300000) can0 18FEF105#01
"""


def test_a_trace_is_decoded_without_a_dictionary(said, tmp_path):
    path = tmp_path / "field.log"
    path.write_text(TRACE)
    assert said("decode", path) == (
        0,
        "    0.000000  705#00                 boot-up\n"
        "    0.100000  605#4000200000000000   SDO read 0x2000:00\n"
        "    0.101000  585#4B00200090010000   SDO answer 0x2000:00 = 90 01\n"
        "    0.200000  706#7F                 heartbeat pre-operational\n"
        "    0.300000  18FEF105#01\n",
        "",
    )


def test_a_trace_is_decoded_with_the_names_of_several_dictionaries(said, tmp_path, caplog):
    path = tmp_path / "field.log"
    path.write_text(f"{TRACE}damaged\n(1436509052.4) can0 286#D700B004\n")
    code, out, _ = said("decode", path, "--eds", "5=topcon", "--eds", f"6={BLOCK}")
    assert code == 0
    assert "SDO answer 0x2000:00 Nominal voltage = 400\n" in out
    assert "TPDO2 Temperature = 215, Pressure = 1200\n" in out
    assert f"{path}:6: left out, no line of candump: 'damaged'" in caplog.text


@pytest.mark.parametrize(
    ("nodes", "words"),
    [
        ("x=topcon", "--eds x=topcon: write it as 5=DEVICE"),
        ("5=topcom", "did you mean 'topcon'"),
        ("200=topcon", "node id 200 is not in 1..127"),
    ],
)
def test_nonsense_is_told_in_a_line(said, tmp_path, nodes, words):
    path = tmp_path / "field.log"
    path.write_text(TRACE)
    code, out, err = said("decode", path, "--eds", nodes)
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert words in err


@pytest.fixture
def two(tmp_path):
    """The same run recorded twice: once with the time of the day."""

    def traces(change=lambda time, record: (time, record.frame)):
        records = traced(supply)
        first = log(tmp_path / "a.log", records)
        lines = [change(record.time + 1.7e9, record) for record in records]
        second = tmp_path / "b.log"
        second.write_text("".join(f"({time:.6f}) can1 {frame}\n" for time, frame in lines))
        return first, second

    return traces


def test_two_clocks_are_no_difference(said, two):
    code, out, _ = said("diff", *two())
    assert code == 0
    assert out.splitlines()[0] == "B has a clock 1700000000.000000 s ahead, which is left out"
    assert out.splitlines()[1].startswith("the same ")


def test_times_may_be_off_by_what_the_user_says(said, two):
    paths = two(lambda time, record: (time + 0.002 * (record.time > 1), record.frame))
    code, out, _ = said("diff", *paths)
    assert code == 1
    assert "the same frame, 0.002000 s later in B" in out
    assert said("diff", *paths, "--time", "3ms")[0] == 0


def test_one_direction_is_compared_if_the_user_says_so(said, two):
    def another(time, record):
        return time, str(record.frame).replace("605#4000", "605#4100")

    paths = two(another)
    assert said("diff", *paths)[0] == 1
    assert said("diff", *paths, "--only", "masters")[0] == 1
    assert said("diff", *paths, "--only", "slaves")[0] == 0


def test_the_first_frame_may_lack_on_one_side(said, tmp_path):
    records = traced(lambda bench: Master(bench).read((0x1000, 0), (0x1018, 1)))
    first = log(tmp_path / "a.log", records[1:])
    second = log(tmp_path / "b.log", [r._replace(time=r.time + 1.7e9) for r in records])
    code, out, _ = said("diff", first, second)
    assert code == 1
    assert out.splitlines()[0] == "B has a clock 1700000000.000000 s ahead, which is left out"
    assert "B has 1 frame more, then the other goes on like it" in out
