# SPDX-License-Identifier: BSD-3-Clause
"""The voice is in the robot's mode soon after every word, by voice or by hand."""

from functools import partial

from hypothesis import given
from hypothesis import strategies as st

from voice_assist.config import load_voice_config
from voice_assist.intent.dialogue import AT_START, CommandRecognized, ModeReported, step
from voice_assist.pipeline.robot_mode import RobotMode
from voice_assist.types import Call, Mode

VOICE = load_voice_config()
CONFIG = VOICE.moving
TICK = 0.02  # [s] between two states of the controller
DELAY = 0.4 * CONFIG.settle  # [s] of each way between the two nodes


def test_before_any_report_and_after_the_last_nothing_is_known():
    mode = RobotMode(CONFIG)
    assert mode(0.0) is None
    mode.report(True, 1.0)
    assert mode(1.0 + 0.9 * CONFIG.state_age) is Mode.ACTIVE
    assert mode(1.0 + 1.1 * CONFIG.state_age) is None


def test_a_report_from_before_the_voices_own_word_does_not_undo_it():
    mode = RobotMode(CONFIG)
    mode.calls.send()
    mode.report(False, 1.0)
    assert mode(1.0) is None
    mode.calls.answer(1.0)
    mode.report(False, 1.0 + 0.9 * CONFIG.settle)
    assert mode(1.0 + 0.9 * CONFIG.settle) is None
    mode.report(True, 1.0 + 1.1 * CONFIG.settle)
    assert mode(1.0 + 1.1 * CONFIG.settle) is Mode.ACTIVE


def test_a_word_that_a_stop_made_void_is_not_waited_for():
    mode = RobotMode(CONFIG)
    mode.calls.send()
    mode.calls.drop(1.0)
    mode.report(False, 1.1 + CONFIG.settle)
    assert mode(1.1 + CONFIG.settle) is Mode.STANDBY


class TwoNodes:
    """Voice and robot with a network between them; words by voice and by hand."""

    def __init__(self):
        self.now, self.state, self.mode = 0.0, AT_START, RobotMode(CONFIG)
        self.is_enabled = False
        self.on_the_way = []  # (when it arrives, what it does)
        self.modes = [self.state.mode]

    def say(self, phrase, is_refused):
        done = step(self.state, CommandRecognized(VOICE.commands.get(phrase)))
        self._take(done.state)
        for call in (a for a in done.actions if isinstance(a, Call)):
            self.mode.calls.send()
            self._later(partial(self._called, call.command, is_refused))

    def _called(self, command, is_refused):
        if not is_refused:
            self.by_hand(command)
        self._later(lambda: self.mode.calls.answer(self.now))

    def by_hand(self, command):
        self.is_enabled = command == "hey robot"

    def run(self, seconds):
        for _ in range(round(seconds / TICK)):
            self.now += TICK
            self._later(lambda it=self.is_enabled: self.mode.report(it, self.now))
            due = [act for at, act in self.on_the_way if at <= self.now]
            self.on_the_way = [entry for entry in self.on_the_way if entry[0] > self.now]
            for act in due:
                act()
            if (mode := self.mode(self.now)) is not None:
                self._take(step(self.state, ModeReported(mode)).state)
        return self

    def _take(self, state):
        if state.mode is not self.state.mode:
            self.modes.append(state.mode)
        self.state = state

    def _later(self, act):
        self.on_the_way.append((self.now + DELAY, act))


EVENTS = st.tuples(
    st.sampled_from(["hey robot", "terminate"]),
    st.sampled_from(["voice", "voice, refused", "hand"]),
    st.floats(0.0, 1.5),
)


@given(st.lists(EVENTS, max_size=6))
def test_after_words_by_voice_and_by_hand_both_are_soon_in_one_mode(events):
    nodes = TwoNodes()
    for phrase, by, pause in events:
        if by == "hand":
            nodes.by_hand(phrase)
        else:
            nodes.say(phrase, is_refused="refused" in by)
        nodes.run(pause)
    nodes.run(2 * DELAY + CONFIG.settle + DELAY + TICK)
    assert (nodes.state.mode is Mode.ACTIVE) is nodes.is_enabled


def test_a_spoken_word_changes_the_mode_once_without_going_back_in_between():
    nodes = TwoNodes()
    nodes.run(0.5).say("hey robot", is_refused=False)
    nodes.run(2.0).say("terminate", is_refused=False)
    nodes.run(2.0)
    assert nodes.modes == [Mode.STANDBY, Mode.ACTIVE, Mode.STANDBY]


def test_a_hey_robot_that_the_robot_refuses_leaves_both_in_standby():
    nodes = TwoNodes()
    nodes.run(0.5).say("hey robot", is_refused=True)
    nodes.run(2.0)
    assert nodes.modes == [Mode.STANDBY, Mode.ACTIVE, Mode.STANDBY]
