import pytest

from .conftest import log, read, write

TOPCON = [(0x1000, 0), (0x1008, 0), (0x1018, 1), (0x1018, 2), (0x2000, 0), (0x2010, 0)]


def usual(bench):
    """What a master does with a TopCon: look who it is, start it, set values, stop it."""
    read(bench, *TOPCON)
    write(bench, 0x1017, 0, 100)
    bench.send("000#0105")
    for index, value in ((0x2010, 2000), (0x2011, 1000), (0x2014, 1)):
        write(bench, index, 0, value)
    bench.run(0.5)
    bench.send("185#R")
    write(bench, 0x2030, 0, 1900)  # below the output: an emergency
    bench.run(0.3)
    read(bench, (0x2023, 0), (0x2FFF, 0))
    write(bench, 0x2014, 0, 2)
    bench.send("000#8105")
    bench.run(0.3)
    read(bench, *TOPCON)


def test_a_twin_agrees_with_itself(field, said):
    code, out, err = said("compare", "topcon", "-n", "5", field(usual))
    assert (code, err) == (0, "")
    assert out.splitlines()[0] == "100 %: 57 of 57 agree"


def test_a_device_that_is_another_is_told_by_object_and_exit_code(field, said):
    trace = field(usual, unit="TCP-16-100")
    code, out, _ = said("compare", "topcon", "-n", "5", trace)
    assert code == 1
    assert "SDO 0x2000:00 Nominal voltage: another value, 2 times" in out


def test_a_trace_without_the_node_is_told_with_those_it_has(field, said):
    code, out, err = said("compare", "topcon", "-n", "6", field(usual))
    assert (code, out) == (2, "")
    assert err == "canopen-twin: the trace has nothing of node 6 (topcon), but of node 5\n"


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (("topcom", "-n", "5"), "did you mean 'topcon'"),
        (("topcon", "-n", "200"), "node id 200 is not in 1..127"),
        (("topcon", "--set", "unit=none"), "none"),
    ],
)
def test_nonsense_is_told_in_a_line(field, said, arguments, told):
    code, out, err = said("compare", *arguments, field(usual))
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert told in err


def test_a_trace_of_nothing_is_told(tmp_path, said):
    code, _, err = said("compare", "topcon", log(tmp_path / "empty.log", []))
    assert (code, err) == (2, "canopen-twin: the trace has nothing of node 1 (topcon)\n")
