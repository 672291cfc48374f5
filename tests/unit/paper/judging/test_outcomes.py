# SPDX-License-Identifier: BSD-3-Clause
from dataclasses import replace

import numpy as np
import pytest

from paper.config import load_experiment
from paper.judging.outcomes import first_braking, first_motion, outcome
from paper.judging.recording import NAMES, HeardDecision, JointTrack, Recorded, RecordedAnswer
from paper.judging.trials import SpokenTrial, append, read
from paper.judging.truth import Sounded

CONFIG = load_experiment()
T0 = 1_700_000.0  # [s]
TRIAL = SpokenTrial(
    1, "pull more", "pull more", "phrases/0001.wav", T0, T0 + 1.0, 1.0, 0.5, True, ""
)
SOUNDED = Sounded(T0 + 0.1, T0 + 0.8, 0.98)
NEVER = float("inf")


def decision(after, command, transcript=None, reason=""):
    return HeardDecision(T0 + after, command, transcript or command, reason, 0.9, T0 + 0.9)


def joints(speed_of, begin=0.0, end=5.0, noise=0.0):
    """Rows of the recording: every joint turns at a speed [rad/s] that depends on time."""
    rng = np.random.default_rng(1)
    times = np.arange(begin, end, 0.002)
    speed = np.array([speed_of(t) for t in times])
    way = np.cumsum(speed) * 0.002
    return [
        (T0 + t, np.full(len(NAMES), q) + noise * rng.standard_normal(len(NAMES)),
         np.full(len(NAMES), v))
        for t, q, v in zip(times, way, speed, strict=True)
    ]  # fmt: skip


def told(*decisions, diary=(), joints_=(), trial=TRIAL, sounded=SOUNDED, until=NEVER):
    recorded = Recorded(decisions=list(decisions), diary=list(diary), joints=list(joints_))
    return outcome(trial, sounded, recorded, until, CONFIG)


def accepted(after, command="pull more"):
    return RecordedAnswer(T0 + after, "accepted", command, "")


def test_times_count_from_the_end_of_the_sound_not_from_the_detector():
    result = told(
        decision(1.2, "pull more"),
        diary=[accepted(1.21)],
        joints_=joints(lambda t: 0.05 if t > 1.5 else 0.0, noise=1e-5),
    )
    assert result.is_correct and result.taken == ("pull more",)
    assert result.decided == pytest.approx(0.4)
    assert result.acted == pytest.approx(0.7 + CONFIG.motion / 0.05, abs=0.005)
    assert result.detected == pytest.approx(0.1)
    assert result.sounded == pytest.approx(0.1)


def test_a_decision_before_the_end_of_the_sound_has_a_negative_time():
    assert told(decision(0.7, "pull more"), diary=[accepted(0.71)]).decided == pytest.approx(-0.1)


def test_a_refused_command_is_heard_but_not_acted_on():
    refusal = RecordedAnswer(T0 + 1.21, "refused", "pull more", "tension limit")
    moving = joints(lambda t: 0.05)
    result = told(decision(1.2, "pull more"), diary=[refusal], joints_=moving)
    assert result.is_correct and result.refusal == "tension limit"
    assert np.isnan(result.acted)


def test_a_command_taken_for_another_is_wrong_and_has_no_times():
    result = told(decision(1.2, "pull less"), diary=[accepted(1.21, "pull less")])
    assert not result.is_correct and result.taken == ("pull less",)
    assert np.isnan(result.decided) and np.isnan(result.acted)


def test_a_second_command_from_one_phrase_is_wrong():
    assert not told(decision(1.2, "pull more"), decision(1.6, "stop")).is_correct


def test_a_missed_command_keeps_what_was_heard_and_why_nothing_came_of_it():
    result = told(decision(1.2, "", "pull moon", "WER 0.50"))
    assert not result.is_correct
    assert (result.transcript, result.reason) == ("pull moon", "WER 0.50")


def test_nothing_heard_is_said_so():
    assert told().reason == "nothing heard"


def test_talk_is_right_when_nothing_is_taken():
    talk = replace(TRIAL, command="", words="rowboat")
    assert told(decision(1.2, "", "robot"), trial=talk).is_correct
    assert not told(decision(1.2, "hey robot"), trial=talk).is_correct


def test_decisions_of_the_phrases_before_and_after_are_not_its_own():
    result = told(decision(-0.5, "tense"), decision(4.5, "release"), until=T0 + 4.0)
    assert result.taken == ()


def test_sound_that_was_torn_apart_is_marked():
    result = told(decision(1.2, "pull more"), diary=[accepted(1.21)], sounded=None)
    assert not result.is_whole and np.isnan(result.decided)


def test_commands_without_motion_act_when_they_are_answered():
    trial = replace(TRIAL, command="hey robot")
    result = told(
        decision(1.2, "hey robot"), diary=[accepted(1.25, "hey robot")], trial=trial,
        joints_=joints(lambda t: 0.0),
    )  # fmt: skip
    assert result.acted == pytest.approx(0.45)


def test_a_stop_acts_when_the_robot_brakes_and_ends_when_it_rests():
    def speed(t):
        return float(np.clip(0.05 - 0.5 * max(t - 1.3, 0.0), 0.0, 0.05))  # brakes for 0.1 s

    trial = replace(TRIAL, command="stop", interrupts="tense")
    received = RecordedAnswer(T0 + 1.21, "stop_received", "", "spoken")
    result = told(decision(1.2, "stop"), diary=[received], joints_=joints(speed), trial=trial)
    assert result.acted == pytest.approx(0.5 + 0.1 * (1.0 - CONFIG.braking), abs=0.005)
    assert result.rested == pytest.approx(0.6, abs=0.01)


def test_a_stop_at_rest_has_nothing_to_brake():
    trial = replace(TRIAL, command="stop")
    received = RecordedAnswer(T0 + 1.21, "stop_received", "", "spoken")
    still = joints(lambda t: 0.0)
    result = told(decision(1.2, "stop"), diary=[received], joints_=still, trial=trial)
    assert result.is_correct and np.isnan(result.acted) and np.isnan(result.rested)


def arrays(rows):
    t, q, v = (np.array(column) for column in zip(*rows, strict=True))
    return JointTrack(t, q, v)


def test_noise_at_rest_is_no_motion():
    some = arrays(joints(lambda t: 0.0, noise=5e-5))
    assert np.isnan(first_motion(some, T0 + 1.0, CONFIG.motion))


def test_joints_that_were_not_recorded_before_the_decision_say_nothing():
    some = arrays(joints(lambda t: 0.05, begin=2.0))
    assert np.isnan(first_motion(some, T0 + 1.0, CONFIG.motion))
    assert np.isnan(first_braking(some, T0 + 1.0, CONFIG.braking))


def test_trials_come_back_as_they_were_kept(tmp_path):
    assert read(tmp_path) == []
    append(tmp_path, TRIAL)
    append(tmp_path, replace(TRIAL, index=2, interrupts="tense"))
    assert read(tmp_path) == [TRIAL, replace(TRIAL, index=2, interrupts="tense")]
