# SPDX-License-Identifier: BSD-3-Clause
import pytest

from tests.unit.voice_assist.support.fake_pipeline import COMMANDS, commands, make, refusals, run
from tests.unit.voice_assist.support.fake_speech import FakeRecognizer, frames, say
from voice_assist.audio.robot_speech import RobotSpeech, RobotSpeechChange
from voice_assist.config import load_voice_config
from voice_assist.types import Mode

CONFIG = load_voice_config().audio.robot_speech
SILENCE = load_voice_config().recognizer.early.silence_added  # [s] behind what ends
START = 100.0  # [s] stamp of the first frame
REASON = "the robot itself was speaking; say it again"


def hear(text, *reports, mode=Mode.ACTIVE, recognizer=None):
    """A sentence, and what is reported of the loudspeaker, with the second of it."""
    pipeline, clock = make(mode, recognizer)
    for at, is_speaking in reports:
        pipeline.robot_spoke(RobotSpeechChange(is_speaking, START + at))
    return run(pipeline, clock, frames(say(text), start=START))


@pytest.mark.parametrize("command", COMMANDS)
def test_the_robots_own_voice_neither_moves_nor_wakes_it_and_may_stop_it(command):
    events = hear(command, (0.0, True))
    is_taken = command in ("stop", "terminate")
    assert commands(events) == [command] * is_taken
    refused = [(r.nearest_command, r.rejection.words) for r in refusals(events)]
    assert is_taken or refused == [(command, REASON)]


@pytest.mark.parametrize("command", COMMANDS)
def test_once_it_has_ended_everything_counts_again(command):
    events = hear(command, (-5.0, True), (-CONFIG.tail, False))
    assert commands(events) == [command]


@pytest.mark.parametrize(
    ("reports", "counts"),
    [
        ([(-5.0, True), (0.4, False)], False),  # it spoke when the word began
        ([(-CONFIG.max_duration, True)], True),  # its end need not be reported
        ([(-CONFIG.max_duration + 1.0, True)], False),
        ([(0.5, False)], True),  # an end without a beginning
        ([(600.0, True), (601.0, False)], True),  # the clock was set back since
    ],
)
def test_speech_that_began_while_it_spoke_does_not_count(reports, counts):
    assert commands(hear("tense", *reports)) == ["tense"] * counts


def test_it_cannot_wake_what_its_own_stop_has_stopped():
    events = hear("stop 0.5 hey robot", (0.0, True), mode=Mode.ACTIVE)
    assert commands(events) == ["stop"]


def test_a_beginning_reported_again_lasts_longer():
    robot_speech = RobotSpeech(CONFIG)
    robot_speech.update(RobotSpeechChange(True, 0.0))
    robot_speech.update(RobotSpeechChange(True, 10.0))
    assert robot_speech.is_in(10.0 + CONFIG.max_duration)
    assert not robot_speech.is_in(10.1 + CONFIG.max_duration)
    robot_speech.reset()
    assert not robot_speech.is_in(0.0)


OVER = "the now mumble 0.3 stop 0.3 mumble the now"


def test_a_stop_in_the_midst_of_its_own_voice_counts():
    assert commands(hear(OVER, (0.0, True))) == ["stop"]
    assert commands(hear(OVER, (0.0, True), mode=Mode.STANDBY)) == ["stop"]


def test_in_the_midst_of_somebody_elses_it_does_not():
    assert commands(hear(OVER)) == []
    assert commands(hear(OVER, (-5.0, True), (-CONFIG.tail - 0.1, False))) == []


def test_what_is_no_stop_or_unsure_does_not_count_in_its_midst():
    for word in ("tense", "pull more"):
        assert commands(hear(OVER.replace("stop", word), (0.0, True))) == []
    unsure = CONFIG.stop_over_speech_confidence - 0.01
    assert commands(hear(OVER, (0.0, True), recognizer=FakeRecognizer(confidence=unsure))) == []


def test_its_midst_is_decoded_only_while_it_speaks():
    recognizer = FakeRecognizer()
    hear(OVER, recognizer=recognizer)
    before = len(recognizer.heard)
    hear(OVER, (0.0, True), recognizer=recognizer)
    passes = recognizer.heard[before:]
    assert sum(length <= CONFIG.window + SILENCE for length in passes) > before / 2
