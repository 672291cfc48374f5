# SPDX-License-Identifier: BSD-3-Clause
from hypothesis import given
from hypothesis import strategies as st

from voice_assist.config import load_voice_config
from voice_assist.pipeline.robot_motion import AT_REST, RobotMotion

CONFIG = load_voice_config().moving
FRESH, STALE = 0.9 * CONFIG.state_age, 1.1 * CONFIG.state_age
REST_STATES = st.sampled_from(sorted(AT_REST))
STATES = st.sampled_from([*sorted(AT_REST), "moving", "stopping", "a state of tomorrow"])


def motion(is_armed=False, state=None, is_assistance_enabled=False, at=0.0):
    rule = RobotMotion(CONFIG)
    rule.arm(is_armed)
    if state is not None:
        rule.report(state, is_assistance_enabled, at)
    return rule


def test_before_anything_is_known_it_moves_only_where_assistance_is_enabled():
    assert not motion().is_moving(0.0)
    assert motion(is_armed=True).is_moving(0.0)


@given(state=STATES, is_armed=st.booleans())
def test_a_fresh_state_decides(state, is_armed):
    assert motion(is_armed, state).is_moving(FRESH) is (state not in AT_REST)


@given(state=STATES, is_armed=st.booleans(), is_enabled=st.booleans())
def test_a_stale_state_counts_as_motion_while_assistance_is_enabled(state, is_armed, is_enabled):
    in_doubt = is_armed or is_enabled or state not in AT_REST
    assert motion(is_armed, state, is_enabled).is_moving(STALE) is in_doubt


def test_a_motion_that_is_sent_counts_until_its_answer_is_settled():
    rule = motion(state="active")
    rule.calls.send()
    rule.report("active", True, 5.0)
    assert rule.is_moving(5.0)
    rule.calls.answer(5.0)
    for time in (5.0 + 0.5 * CONFIG.settle, 5.0 + 1.1 * CONFIG.settle):
        rule.report("active", True, time)
        assert rule.is_moving(time) is (time < 5.0 + CONFIG.settle)


def test_two_motions_that_are_sent_need_two_answers():
    rule = motion()
    rule.calls.send()
    rule.calls.send()
    rule.calls.answer(0.0)
    rule.report("active", True, 9.0)
    assert rule.is_moving(9.0)


def test_motions_that_are_dropped_do_not_count_for_ever_and_a_stop_at_rest_moves_nothing():
    rule = motion(state="halted", at=9.0)
    rule.calls.drop(9.0)
    assert not rule.is_moving(9.0)
    rule.calls.send()
    rule.calls.drop(9.0)
    assert rule.is_moving(9.0 + 0.5 * CONFIG.settle)
    rule.report("halted", True, 9.0 + 2 * CONFIG.settle)
    assert not rule.is_moving(9.0 + 2 * CONFIG.settle)


EVENTS = st.one_of(
    st.tuples(st.just("report"), STATES, st.booleans()),
    st.tuples(st.just("arm"), st.booleans()),
    st.sampled_from([("send",), ("answer",), ("drop",), ("wait", 0.05), ("wait", 1.0)]),
)


@given(st.lists(EVENTS, max_size=30))
def test_after_any_events_it_is_never_at_rest_by_mistake(events):
    rule, now, moving_at, armed, unanswered = RobotMotion(CONFIG), 0.0, None, False, 0
    for name, *values in events:
        match name:
            case "wait":
                now += values[0]
            case "report":
                rule.report(*values, now)
                moving_at = now if values[0] not in AT_REST else None
            case "arm":
                rule.arm(*values)
                armed = values[0]
            case "send":
                rule.calls.send()
                unanswered += 1
            case "answer":
                rule.calls.answer(now)
                unanswered = max(unanswered - 1, 0)
            case "drop":
                rule.calls.drop(now)
                unanswered = 0
        must = unanswered or moving_at is not None
        if must:
            assert rule.is_moving(now)
    if armed:
        assert rule.is_moving(now + 10 * CONFIG.state_age)


@given(st.lists(EVENTS, max_size=30), REST_STATES)
def test_after_any_events_a_fresh_state_of_rest_is_believed_once_all_is_answered(events, state):
    rule = RobotMotion(CONFIG)
    for name, *values in events:
        if name == "report":
            rule.report(*values, 0.0)
        elif name == "arm":
            rule.arm(*values)
        elif name == "send":
            rule.calls.send()
    rule.calls.drop(0.0)
    rule.report(state, True, 2 * CONFIG.settle)
    assert not rule.is_moving(2 * CONFIG.settle)


def test_switched_off_the_robot_never_counts_as_moving():
    off = load_voice_config(moving__is_enabled=False).moving
    rule = RobotMotion(off)
    rule.arm(True)
    rule.calls.send()
    rule.report("moving", True, 0.0)
    assert not rule.is_moving(0.0)
