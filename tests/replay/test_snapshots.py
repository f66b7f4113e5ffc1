"""What is shown of the moment at which something was not as it should be."""

from canopen_twins.scenario import play

BEATS = "- {at: 0, write: {Producer heartbeat: 100}}\n"


def scene_of(scenario):
    (scene,) = [each.scene for each in play(scenario).outcomes if each.scene]
    return scene.splitlines()


def test_the_first_frames_after_it_are_shown_too(story):
    lines = scene_of(
        story(f"{BEATS}- {{at: 0.25, expect: {{value: {{Byte: 1}}}}}}\n- {{at: 2, nmt: stop}}\n")
    )
    here = next(number for number, line in enumerate(lines) if "here" in line)
    assert lines[here].split()[0] == "0.250000"
    assert [line.split()[0] for line in lines[here - 2 : here]] == ["0.100000", "0.200000"]
    after = [line.split() for line in lines[here + 1 : here + 6]]
    assert [(time, frame) for time, _, frame, *_ in after] == [
        (f"0.{tenth}00000", "705#7F") for tenth in range(3, 8)
    ]
    assert after[0][3:] == ["heartbeat", "pre-operational"]
    assert lines[here + 6].startswith("probe: node 5, PRE-OPERATIONAL")


def test_what_the_run_has_left_is_shown_if_it_ends_before(story):
    lines = scene_of(
        story(f"{BEATS}- {{at: 0.25, expect: {{value: {{Byte: 1}}}}}}\n- {{at: 0.35, nmt: stop}}\n")
    )
    here = next(number for number, line in enumerate(lines) if "here" in line)
    assert [line.split()[2] for line in lines[here + 1 : -2]] == ["705#7F", "000#0205"]


def test_every_node_is_shown_as_it_was_at_that_moment(loaded):
    lines = scene_of(
        loaded(
            """\
            version: 1
            nodes: {left: {device: probe, node_id: 5}, right: {device: probe, node_id: 6}}
            steps:
              - {at: 1, node: left, nmt: start}
              - {at: 1, node: right, inject: {frame_lost: {frame: 111#}}}
              - {at: 2, node: left, expect: {value: {Byte: 1}}}
              - {at: 3, node: right, clear: all}
              - {at: 3, node: left, power: off}
            """
        )
    )
    assert lines[-4:] == [
        "left: node 5, OPERATIONAL",
        "  faults: none",
        "right: node 6, PRE-OPERATIONAL",
        "  faults: frame_lost(frame=111#)",
    ]


def test_what_passed_or_was_left_out_has_no_scene(story):
    verdict = play(
        story(
            "- {at: 1, expect: {emcy: none, within: 1}}\n"
            "- {at: 3, write: {Refusing: 1}}\n- {at: 4, expect: {emcy: none, within: 1}}\n"
        )
    )
    assert [bool(outcome.scene) for outcome in verdict.outcomes] == [False, True, False]
