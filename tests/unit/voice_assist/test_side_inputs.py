# SPDX-License-Identifier: BSD-3-Clause
import pytest

from voice_assist.side_inputs import SideInput, SideInputKind, SideInputs, from_text, to_text


@pytest.mark.parametrize("kind", SideInputKind)
def test_text_and_back_is_the_same(kind):
    one = SideInput(kind, 512, 1024, "pull more", True, 'it said "no" \n', mode="active")
    assert from_text(to_text(one)) == one
    assert "\n" not in to_text(one)


@pytest.mark.parametrize(
    "line",
    [
        *("", "{}", "[]", '{"kind": "tired", "sample": 1}', '{"kind": "lost"}'),
        *('{"kind": "robot mode", "sample": 1}', '{"kind": "robot mode", "sample": 1, "mode": 1}'),
    ],
)
def test_other_text_is_refused(line):
    with pytest.raises(ValueError, match="is no side input"):
        from_text(line)


def test_answers_are_taken_once_and_in_order_before_their_frame():
    said = [
        SideInput(SideInputKind.ANSWERED, s, 0, c) for s, c in ((512, "a"), (512, "b"), (2048, "c"))
    ]
    past = SideInputs(said)
    assert [past.take_reported(sample) for sample in (0, 512, 1024, 1536)] == [[], said[:2], [], []]
    assert past.take_reported(4096) == said[2:]


def test_progress_is_the_furthest_sample():
    past = SideInputs(SideInput(SideInputKind.HEARD, s) for s in (15_872, 31_744))
    assert past.heard_until == 31_744
    assert SideInputs([]).heard_until == 0


def test_the_robot_moves_from_the_frame_of_its_note_to_that_of_the_next():
    notes = ((512, True), (1536, False))
    past = SideInputs(SideInput(SideInputKind.MOVING, s, is_moving=m) for s, m in notes)
    found = [past.is_moving(sample) for sample in (0, 512, 1024, 1536, 2048)]
    assert found == [False, True, True, False, False]
    assert not SideInputs([]).is_moving(4096)
