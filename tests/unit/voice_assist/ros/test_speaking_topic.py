# SPDX-License-Identifier: BSD-3-Clause
from types import SimpleNamespace

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.unit.voice_assist.support.heard import Heard
from voice_assist.audio.robot_speech import RobotSpeech, RobotSpeechChange
from voice_assist.config import load_voice_config
from voice_assist.ros.robot.robot_speech import RobotSpeechTopic

CONFIG = load_voice_config().audio.robot_speech
REPORTS = st.lists(st.tuples(st.booleans(), st.floats(0.0, 0.03)), max_size=50)


class Topic:
    """A topic whose messages a test makes."""

    def __init__(self):
        self.now = 0.0
        self.heard = Heard()
        self.topic = RobotSpeechTopic(lambda: self.now, self.heard, CONFIG.max_duration)

    def report(self, is_speaking, by="/alarms"):
        header = {"callerid": by}
        message = SimpleNamespace(data=is_speaking, _connection_header=header)
        self.heard.callbacks["voice_assist/speaking"](message)


@pytest.fixture
def topic():
    return Topic()


def test_what_is_reported_is_taken_once(topic):
    assert topic.heard.by == {"voice_assist/speaking": "speaker"}
    topic.now = 3.0
    topic.report(True)
    assert topic.topic.take() == [RobotSpeechChange(True, 3.0)]
    assert topic.topic.take() == []


def test_speech_ends_when_no_loudspeaker_is_left_that_speaks(topic):
    taken = []
    begun, over = ((0.0, True, "/tts"), (2.0, True, "/alarms")), ((3.0, False, "/alarms"),)
    for topic.now, is_speaking, by in (*begun, *over, (8.0, False, "/tts")):
        topic.report(is_speaking, by)
        taken += topic.topic.take()
    assert [(t.is_speaking, t.time) for t in taken] == [(True, 0.0), (True, 2.0), (False, 8.0)]


def test_a_node_that_died_while_it_spoke_holds_up_no_end_for_longer_than_speech_counts(topic):
    topic.report(True, "/tts")
    topic.now = CONFIG.max_duration + 1.0
    topic.report(True, "/alarms")
    topic.report(False, "/alarms")
    assert topic.topic.take()[-1] == RobotSpeechChange(False, topic.now)


@given(REPORTS)
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_however_often_it_is_reported_no_more_than_two_are_left_that_mean_the_same(topic, reports):
    topic.now, everything, left = 0.0, RobotSpeech(CONFIG), RobotSpeech(CONFIG)
    for is_speaking, later in reports:
        topic.now += later
        topic.report(is_speaking)
        everything.update(RobotSpeechChange(is_speaking, topic.now))
    taken = topic.topic.take()
    assert len(taken) <= 2
    for spoke in taken:
        left.update(spoke)
    ends = CONFIG.tail + topic.now, CONFIG.max_duration, CONFIG.max_duration + topic.now
    for at in (0.0, 0.3, *ends):
        assert left.is_in(at) == everything.is_in(at)
