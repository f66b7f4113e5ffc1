import pytest

from canopen_twins import Bench, UserError


@pytest.fixture
def told(tmp_path):
    """What is told of a configuration, a line each, without the name of the file."""

    def told(text):
        file = tmp_path / "configuration.yaml"
        file.write_text(text)
        with pytest.raises(UserError) as refusal:
            Bench("gateway", config=str(file))
        lines = str(refusal.value).splitlines()
        assert all(line.startswith(f"{file}:") for line in lines)
        return [line.removeprefix(f"{file}:") for line in lines]

    return told


def test_numbers_and_names_can_be_used(tmp_path):
    file = tmp_path / "configuration.yaml"
    file.write_text(
        "version: 1\n"
        "gateway: {CanOpenMyNodeID: 5, 429: 0x1F4}\n"
        "governor:\n  409: 500\n  400: 1.5\n  835: -3\n"
    )
    bench = Bench("gateway", config=str(file))
    bench.run(0.5)
    desk = bench.device
    assert (desk.node_id, desk.gateway[429]) == (5, 500)
    assert (desk.governor[416], desk.governor[400], desk.governor[835]) == (500, 1.5, -3)


def test_the_node_id_of_the_settings_comes_first(tmp_path):
    file = tmp_path / "configuration.yaml"
    file.write_text("version: 1\ngateway: {427: 5, 429: 0}\n")
    bench = Bench("gateway", config=str(file), node_id=7)
    assert bench.run(0.5) == ["707#00"]


@pytest.mark.parametrize(
    ("text", "problems"),
    [
        ("gateway: {}", ["1:1: 'version' is missing"]),
        ("version: 2", ["1:10: version 2 is unknown; this is 1"]),
        (
            "version: 1\nmotor: {}",
            ["2:1: unknown key 'motor': there is gateway, governor, version"],
        ),
        (
            "version: 1\ngateway:\n  427: 200\n  3600: 5\n  1: 1\n",
            [
                "3:8: gateway 427 CanOpenMyNodeID: 200 is not in 1..127",
                "4:3: gateway 3600 PowerSupply: is only shown",
                "5:3: the gateway has no parameter 1",
            ],
        ),
        (
            "version: 1\ngateway: {CanOpenMyNode: 3}",
            ["2:11: the gateway has no parameter 'CanOpenMyNode', did you mean 'CanOpenMyNodeID'?"],
        ),
        (
            "version: 1\ngateway: {427: 3, CanOpenMyNodeID: 4}",
            ["2:19: CanOpenMyNodeID is parameter 427, which stands above"],
        ),
        (
            "version: 1\ngovernor: {4810: 3}",
            ["2:18: governor 4810 Type_EngineStop: 3 is not in 0..2"],
        ),
        (
            "version: 1\ngateway: {427: five}",
            ["2:16: 'five' is no number; numbers look like 16, 0x10 or 0.5"],
        ),
        (
            "version: 1\ngateway: 5",
            ["2:10: a key with a value is wanted here, such as {key: value}"],
        ),
        ("version: 1\ngateway: {427: 010}", ["2:16: 010 may be taken for different numbers"]),
        ("version: 1\ngateway: {", ["2:11: "]),
    ],
)
def test_everything_that_is_wrong_is_told_with_its_place(told, text, problems):
    found = told(text)
    assert len(found) == len(problems)
    for line, problem in zip(found, problems, strict=True):
        assert line.startswith(problem)


def test_a_file_that_is_not_there_is_told():
    with pytest.raises(UserError, match=r"nowhere.yaml: No such file"):
        Bench("gateway", config="nowhere.yaml")


@pytest.mark.parametrize("setting", ["scaling", "error_bits"])
@pytest.mark.parametrize("content", ["error bits: [", "x", None])
def test_a_table_that_cannot_be_used_is_told_in_one_line(tmp_path, setting, content):
    file = tmp_path / "table"
    if content:
        file.write_text("number,full_scale,unit\n2000,1,rpm\n" if setting == "scaling" else content)
    with pytest.raises(UserError) as refusal:
        Bench("gateway", **{setting: str(file)})
    assert str(file) in str(refusal.value)
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("error bits: {}\nerror bits: {}", "2:1: 'error bits' stands here twice"),
        ("error bits: {}", "1:1: the keys are not just 'error bits' and 'engine state bits'"),
        ("error bits: {1: [03000]}", "1:18: 03000 may be taken for different numbers"),
    ],
)
def test_a_table_of_bits_is_told_with_its_place(tmp_path, text, told):
    file = tmp_path / "bits.yaml"
    file.write_text(text)
    with pytest.raises(UserError) as refusal:
        Bench("gateway", error_bits=str(file))
    assert f"{file}:{told}" in str(refusal.value)


def test_a_table_as_large_as_a_disk_is_not_read(tmp_path):
    file = tmp_path / "table"
    file.write_bytes(b"#" * (1 << 20) + b"#")
    with pytest.raises(UserError, match="larger than 1024 KiB"):
        Bench("gateway", scaling=str(file))


HEAD = "number,full_scale,unit,counts"


@pytest.mark.parametrize(
    ("content", "told"),
    [
        ("any words\n", "there is no row below the names of the columns"),
        (f"{HEAD}\n2000,4000\n", "line 2: not as many fields as there are columns"),
        (f"{HEAD}\n2000,1,rpm,1,1\n", "line 2: not as many fields as there are columns"),
        (f"{HEAD}\n2000,1,{'rpm' * 70_000},1\n", "field larger than field limit"),
    ],
    ids=["words", "short", "long", "large"],
)
def test_a_scaling_that_is_no_table_of_ours_is_told_in_one_line(tmp_path, content, told):
    file = tmp_path / "table"
    file.write_text(content)
    with pytest.raises(UserError) as refusal:
        Bench("gateway", scaling=str(file))
    assert str(refusal.value).startswith(f"{file}: {told}")
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize("setting", ["boot_time", "governor_cycle"])
def test_times_are_on_the_grid(setting):
    with pytest.raises(UserError, match=r"a setting in seconds: 0.0301 s is not a multiple of 125"):
        Bench("gateway", **{setting: 0.0301})
