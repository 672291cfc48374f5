# SPDX-License-Identifier: BSD-3-Clause
"""What the live pipeline decided must be decided again from what was recorded of it."""

import random
from dataclasses import replace

import pytest

from tests.unit.voice_assist.support import replayed_pipeline
from tests.unit.voice_assist.support.fake_pipeline import commands, refusals
from tests.unit.voice_assist.support.fake_speech import FakeRecognizer, frames, say
from tests.unit.voice_assist.support.replayed_pipeline import (
    CONFIG,
    FakeReplay,
    Live,
    again,
    as_decided,
    as_heard,
)
from voice_assist.audio.robot_speech import RobotSpeechChange
from voice_assist.config import load_voice_config
from voice_assist.intent.dialogue import Answered
from voice_assist.replay.recorded_spotter import RecordedSpotter
from voice_assist.side_inputs import SideInput, SideInputKind, SideInputs, from_text
from voice_assist.spotter.spotter import NEWEST, Spotted
from voice_assist.types import Match, Mode

TALK = (
    "0.3 tense 0.8 hey robot 0.8 he said pull more 0.8 tense 0.8 stop pulling 0.8 hey robot"
    " 0.6 terminate"
)


def test_what_was_decided_is_decided_again_and_how_far_hearing_came_is_on_record():
    live = Live().hear(frames(say(TALK)))
    taken = ["hey robot", "tense", "stop", "hey robot", "terminate"]
    assert commands(live.decisions) == taken
    assert refusals(live.decisions)
    assert as_heard(again(live)) == as_decided(live.decisions)
    past = SideInputs(map(from_text, live.notes))
    last = live.blocks[-1].first_sample
    assert last - 16_512 <= past.heard_until <= last


def test_skipped_decoder_passes_are_skipped_again():
    """Without the notes the same sound is decoded more often."""
    rng = random.Random(1)
    spells = [rng.random() < 0.5 for _ in range(100)]
    live = Live(late=lambda f: 2.0 if spells[f.first_sample // 8_000] else 0.0)
    live.hear(frames(say(TALK)))
    kinds = [from_text(note).kind for note in live.notes]
    assert kinds.count(SideInputKind.BEHIND) > 10
    noted, unnoted = FakeRecognizer(), FakeRecognizer()
    assert as_heard(again(live, recognizer=noted)) == as_decided(live.decisions)
    assert noted.heard == live.recognizer.heard
    again(live, notes=[], recognizer=unnoted)
    assert len(unnoted.heard) > len(noted.heard)


@pytest.mark.parametrize("seed", range(3))
def test_frames_that_recognition_never_heard_are_left_out_again(seed):
    rng = random.Random(seed)
    gone = {first for first in range(0, 200_000, 512) if rng.random() < 0.02}
    live = Live(unheard=lambda f: f.first_sample in gone).hear(frames(say(TALK)))
    assert as_heard(again(live)) == as_decided(live.decisions)
    assert as_heard(again(live, notes=[])) != as_decided(live.decisions)


def test_a_gap_that_the_node_noticed_is_on_record():
    sound = frames(say(TALK))
    live = Live().hear(sound[:100] + sound[120:])
    past = SideInputs(map(from_text, live.notes))
    assert past.get(SideInputKind.LOST, sound[120].first_sample)
    assert as_heard(again(live)) == as_decided(live.decisions)


def test_answers_of_the_controller_are_given_again():
    live = Live().hear(frames(say("hey robot 0.8 tense 0.8")))
    past = SideInputs(map(from_text, live.notes))
    replayed = FakeReplay(CONFIG, FakeRecognizer(), None, past)
    for block in live.blocks:
        replayed.hear(block)
    reason = "tense, refused by the robot: nothing is grasped"
    assert live.pipeline.state == replayed._pipeline.state
    live.pipeline.set_mode(live.pipeline.state.mode, "tense")
    live.pipeline.answer(Answered("tense", False, "nothing is grasped"))
    assert live.pipeline.state.reason == reason


def test_what_was_reported_of_the_robots_own_speech_is_reported_again():
    live, sound = Live(), frames(say("hey robot 0.8 tense 0.8 tense"))
    early, middle = sound[: 2 * len(sound) // 3], sound[2 * len(sound) // 3 :]
    live.hear(early)
    live.pipeline.robot_spoke(RobotSpeechChange(True, middle[0].stamp))
    live.hear(middle)
    assert [isinstance(d.outcome, Match) for d in live.decisions] == [True, True, False]
    assert as_heard(again(live)) == as_decided(live.decisions)
    assert as_heard(again(live, notes=[])) != as_decided(live.decisions)


def test_when_people_learned_of_a_question_is_taken_again(monkeypatch):
    twice = load_voice_config(commands__said_twice=True)
    monkeypatch.setattr(replayed_pipeline, "CONFIG", twice)
    live, sound = Live(), iter(frames(say("hey robot 0.8 tense 4.0 tense")))
    while len(live.decisions) < 2:
        live.hear([next(sound)])
    live.pipeline.question_shown(live.now + 1.5)
    live.hear(sound)
    assert commands(live.decisions) == ["hey robot", "tense"]
    assert as_heard(again(live)) == as_decided(live.decisions)
    assert as_heard(again(live, notes=[])) != as_decided(live.decisions)


def test_a_mode_that_was_set_by_hand_is_taken_again():
    live, sound = Live(), frames(say("tense 0.8 tense"))
    live.hear(sound[: len(sound) // 2])
    live.pipeline.follow(Mode.ACTIVE)
    live.pipeline.follow(Mode.ACTIVE)  # a report of the same mode is no news
    live.hear(sound[len(sound) // 2 :])
    assert [d.mode for d in live.decisions] == [Mode.STANDBY, Mode.ACTIVE]
    assert sum('"robot mode"' in note for note in live.notes) == 1
    assert as_heard(again(live)) == as_decided(live.decisions)
    assert as_heard(again(live, notes=[])) != as_decided(live.decisions)


def test_a_stop_in_a_sentence_is_decided_again_as_the_robot_moved_then():
    sound = [
        replace(frame, is_moving=frame.stamp > 104.0)
        for frame in frames(say("he said stop now 3 he said stop now"))
    ]
    live = Live()
    first = next(frame for frame in sound if frame.is_moving)
    live.observe(SideInput(SideInputKind.MOVING, first.first_sample, is_moving=True))
    live.hear(sound)
    assert commands(live.decisions) == ["stop"]
    assert as_heard(again(live)) == as_decided(live.decisions)
    assert all(not heard.command for heard in again(live, notes=[]))


# --- the spotter


class Listening:
    """Scores each frame at once, and fires with the frames given."""

    def __init__(self, fires):
        self.fires, self.scores = fires, []

    def __call__(self, frame):
        until = frame.next_sample
        self.scores.append((until, float(frame.first_sample % 7919)))
        return Spotted(frame.stamp, 9.0) if frame.first_sample in self.fires else None

    def best(self, since, until=NEWEST):
        return max((s for u, s in self.scores if u <= until), default=float("-inf"))

    def reset(self):
        """Nothing."""


@pytest.mark.parametrize("seed", range(20))
def test_a_thread_that_lags_is_recalled_exactly(seed):
    """A model of SpotterThread, whose progress is random, against its recall from the notes."""
    rng = random.Random(seed)
    sound = frames(say("stop 0.5 stop"))
    fires = {f.first_sample for f in sound if rng.random() < 0.1}
    thread, shown, notes = Laggard(Listening(fires), rng), [], []
    for frame in sound:
        shown.append(thread.see(frame, notes))
    recalled = RecordedSpotter(Listening(fires), SideInputs(notes))
    for frame, (spotted, best) in zip(sound, shown, strict=True):
        recalled.feed(frame)
        assert recalled(frame) == spotted
        assert recalled.best(0.0) == best


class Laggard:
    """Hears some of what waits, drops some, and may fail."""

    def __init__(self, spotter, rng):
        self.spotter, self.rng = spotter, rng
        self.waiting, self.found, self.until = [], [], 0
        self.fails_at = rng.choice([None, None, 20_000])
        self.is_deaf = False

    def see(self, frame, notes):
        self.waiting.append(frame)
        if self.rng.random() < 0.05:
            lost = self.waiting.pop(0)
            notes.append(SideInput(SideInputKind.SPOTTER_DROPPED, lost.first_sample))
        until = frame.next_sample
        for _ in range(0 if self.is_deaf else self.rng.choice([0, 1, len(self.waiting)])):
            self._hear_one()
        if not self.is_deaf:
            self._note(frame, until, notes)
        spotted = self.found.pop(0) if self.found else None
        is_there = self.until >= until and not self.is_deaf
        return spotted, self.spotter.best(0.0, self.until) if is_there else None

    def _note(self, frame, until, notes):
        self.is_deaf = self.fails_at is not None and frame.first_sample > self.fails_at
        if self.is_deaf or self.until < until:
            kind = SideInputKind.SPOTTER_FAILED if self.is_deaf else SideInputKind.SPOTTER_LATE
            notes.append(SideInput(kind, frame.first_sample, self.until))

    def _hear_one(self):
        if self.waiting:
            frame = self.waiting.pop(0)
            if spotted := self.spotter(frame):
                self.found.append(Spotted(spotted.time, spotted.score, is_sent=True))
            self.until = frame.next_sample


def test_a_stop_of_the_spotter_is_heard_again():
    sound = frames(say("hey robot 0.8 tense 0.8"))
    fires = {sound[60].first_sample}
    live = Live(spotter=Listening(fires)).hear(sound)
    assert [d.decided_by for d in live.decisions].count("spotter") == 1
    assert as_heard(again(live, spotter=Listening(fires))) == as_decided(live.decisions)
