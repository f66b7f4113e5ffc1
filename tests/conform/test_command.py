import json
from xml.etree import ElementTree

import pytest

from canopen_twins.cli import main


def test_a_slave_that_conforms_ends_with_0(capsys):
    assert main(["conform", "topcon", "--topic", "2.7", "--topic", "11"]) == 0
    first, *others = capsys.readouterr().out.splitlines()
    assert first == "topcon: SKIP (1 PASS, 12 SKIP)"
    assert others[0].endswith(
        "topcon:2.7: A command specifier that does not exist is refused: 05040001h"
        " [CiA 301, 7.2.4.3.17]: as it should be"
    )


def test_one_that_does_not_ends_with_1_and_its_last_frames_in_words(capsys, monkeypatch):
    monkeypatch.setattr("canopen_twins.conform.run.exemptions", lambda eds: {})
    assert main(["conform", "charger", "-n", "5", "--topic", "7.3"]) == 1
    assert capsys.readouterr().out.splitlines()[-2:] == [
        "        605#2B171000FFFF0000   SDO write 0x1017:00 = ff ff",
        "        585#8017100031000906   SDO abort 0x1017:00,"
        " 06090031h Value of parameter written too high",
    ]


def test_programs_get_the_same_as_json_and_junit(capsys, tmp_path):
    file = tmp_path / "conformance.xml"
    assert main(["conform", "gateway", "--topic", "9", "--json", "--junit", str(file)]) == 0
    (told,) = json.loads(capsys.readouterr().out)["scenarios"]
    assert [each["line"] for each in told["outcomes"]] == ["9.1", "9.2", "9.3", "9.4"]
    cases = ElementTree.parse(file).iter("testcase")
    assert [case.get("name")[:4] for case in cases] == ["9.1:", "9.2:", "9.3:", "9.4:"]


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["topcom"], "unknown device 'topcom': did you mean 'topcon'?"),
        (["topcon", "--topic", "2.77"], "unknown topic '2.77': did you mean '2.7'?"),
        (["topcon", "-i", "socketcan", "-c", "can0"], "say --real-bus if you mean it"),
        (["topcon", "-n", "200"], "200"),
    ],
)
def test_nonsense_ends_with_2(capsys, words, told):
    assert main(["conform", *words]) == 2
    assert told in capsys.readouterr().err
