# SPDX-License-Identifier: BSD-3-Clause
"""What the live pipeline decided must be decided again from what was recorded of it."""

import random
from dataclasses import dataclass, is_dataclass, replace
from typing import get_args, get_type_hints

import numpy as np
import pytest
import yaml

from tests.unit.voice_assist.support.fake_speech import FakeRecognizer, frames, make_detector, say
from typed_config import ConfigError, load_yaml
from voice_assist.audio.robot_speech import RobotSpeechChange
from voice_assist.config import CONFIG_DIR, SECTIONS, VoiceConfig, load_voice_config
from voice_assist.intent.dialogue import Answered
from voice_assist.pipeline.pipeline import Pipeline
from voice_assist.replay import replayer as module
from voice_assist.replay.recorded_spotter import RecordedSpotter
from voice_assist.replay.replayer import (
    NotReplayable,
    PipelineReplay,
    replay_pipeline,
    restore_settings,
)
from voice_assist.side_inputs import SideInput, SideInputKind, SideInputs, from_text, to_text
from voice_assist.spotter.fusion import StopFusion
from voice_assist.spotter.spotter import NEWEST, Spotted
from voice_assist.types import FULL_SCALE, Match, Mode, UtteranceDecision

TALK = (
    "0.3 tense 0.8 hey robot 0.8 he said pull more 0.8 tense 0.8 stop pulling 0.8 hey robot"
    " 0.6 terminate"
)
CONFIG = load_voice_config()


@dataclass(frozen=True, eq=False)
class Block:
    """What the topic holds of a frame."""

    samples: np.ndarray
    rate: int
    first_sample: int
    stamp: float


def recorded(frame):
    scaled = np.rint(np.clip(frame.samples, -1.0, 1.0) * FULL_SCALE).astype(np.int16)
    return Block(scaled, 16_000, frame.first_sample, frame.stamp)


class Live:
    """The node's loop around a pipeline, on a machine that is late whenever a test says so."""

    def __init__(self, late=lambda frame: 0.0, unheard=lambda frame: False, spotter=None):
        self.now, self.late, self.unheard = 0.0, late, unheard
        self.notes, self.decisions, self.blocks = [], [], []
        second = StopFusion(CONFIG.spotter, spotter)
        self.recognizer = FakeRecognizer()
        args = self.recognizer, make_detector(), lambda: self.now, second, self.observe
        self.pipeline = Pipeline(CONFIG, *args)

    def observe(self, side_input):
        self.notes.append(to_text(side_input))

    def hear(self, sound):
        for frame in sound:
            self.blocks.append(recorded(frame))
            if self.unheard(frame):
                self.observe(SideInput(SideInputKind.UNHEARD, frame.first_sample))
                continue
            self.now = frame.end + self.late(frame)
            found = [e for e in self.pipeline(frame) if isinstance(e, UtteranceDecision)]
            self.decisions += found
            for decision in found:
                if isinstance(decision.outcome, Match) and decision.outcome.command == "tense":
                    self.pipeline.answer(Answered("tense", False, "nothing is grasped"))
        return self


def again(live, notes=None, spotter=None, recognizer=None):
    """The same sound by way of the recording."""
    past = SideInputs(map(from_text, live.notes if notes is None else notes))
    replayed = FakeReplay(CONFIG, recognizer or FakeRecognizer(), spotter, past)
    return [heard for block in live.blocks for heard in replayed.hear(block)]


class FakeReplay(PipelineReplay):
    """With an endpointing that needs no network."""

    def _build(self, recognizer):
        second = StopFusion(self._config.spotter, self._spotter)
        return Pipeline(self._config, recognizer, make_detector(), lambda: self._now, second)


SAME = ("confidence", "decided_by", "is_partial", "speech_start", "speech_end")


def as_decided(decisions):
    return [
        {
            "transcript": d.hypothesis.text,
            "outcome": d.command or d.rejection.words,
            "wer": d.outcome.wer,
            "mode": d.mode.value,
            **{name: getattr(d, name) for name in SAME},
        }
        for d in decisions
    ]


def as_heard(heard):
    return [
        {
            "transcript": h.transcript,
            "outcome": h.command or h.reason,
            "wer": h.wer,
            "mode": h.mode,
            **{name: getattr(h, name) for name in SAME},
        }
        for h in heard
    ]


def test_what_was_decided_is_decided_again():
    live = Live().hear(frames(say(TALK)))
    assert [d.outcome.command for d in live.decisions if isinstance(d.outcome, Match)] == [
        "hey robot",
        "tense",
        "stop",
        "hey robot",
        "terminate",
    ]
    assert any(not isinstance(d.outcome, Match) for d in live.decisions)
    assert as_heard(again(live)) == as_decided(live.decisions)


def test_a_recording_says_how_far_hearing_came():
    live = Live().hear(frames(say("hey robot")))
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


# --- settings, models, and what cannot be used


def settings():
    return {n: yaml.safe_load((CONFIG_DIR / f"{n}.yaml").read_text()) for n in SECTIONS}


def test_recorded_settings_are_in_force_and_the_device_is_of_this_machine():
    given = settings()
    given["audio"]["vad"]["hangover"] = 0.7
    given["recognizer"]["device"] = "cuda"
    config, warnings = restore_settings(given, None)
    assert config.audio.vad.hangover == 0.7 and config.recognizer.device == "cpu"
    assert warnings == ()


def test_a_model_may_be_given_in_place_of_the_recorded_one():
    config, _ = restore_settings(settings(), "base.en")
    assert config.recognizer.model == "base.en"


def test_settings_of_another_version_are_completed_and_said():
    given = settings()
    del given["spotter"]["patience"]
    given["audio"]["vad"]["louder"] = True
    config, warnings = restore_settings(given, None)
    assert config.spotter.patience == CONFIG.spotter.patience
    assert [w.split(" ")[1] for w in warnings] == ["audio.vad.louder", "spotter.patience"]


def former_keys(kind, value):
    """Settings as a version before the present names recorded them."""
    if isinstance(value, list) and value and isinstance(value[0], dict):
        return [former_keys(get_args(kind)[0], entry) for entry in value]
    if not is_dataclass(kind):
        return value
    former = {now: then for then, now in getattr(kind, "RENAMED", {}).items()}
    hints = get_type_hints(kind)
    return {former.get(key, key): former_keys(hints[key], value[key]) for key in value}


def test_settings_recorded_under_their_former_names_are_restored():
    given = former_keys(VoiceConfig, settings())
    assert "talkback" in given["audio"] and "least_confidence" in given["commands"]["commands"][0]
    assert restore_settings(given, None) == (CONFIG, ())


def test_a_setting_that_is_gone_is_left_out_and_what_came_later_is_off():
    given = settings()
    given["commands"]["commands"][0]["halt_score_threshold"] = 1000.0
    del given["moving"]["nearly_said"]
    config, warnings = restore_settings(given, None)
    assert config.commands == CONFIG.commands and config.moving.nearly_said == -1000.0
    assert warnings == ()


def test_without_recorded_settings_those_of_today_are_used_and_said():
    config, warnings = restore_settings({}, None)
    assert config == CONFIG
    assert warnings == ("no settings were recorded; today's are used",)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (("recognizer", "threads", 0), "threads is 0, allowed"),
        (("recognizer", "model", "no-such-model"), "no file no-such-model"),
        (("spotter", "phrase", "tense"), "spotter.phrase is 'tense'"),
    ],
)
def test_settings_that_cannot_be_used_are_an_error(change, words):
    section, key, value = change
    given = settings()
    given[section][key] = value
    with pytest.raises(NotReplayable, match=words):
        replay_pipeline(given, [], None)


def test_a_note_that_is_none_is_an_error():
    with pytest.raises(NotReplayable, match="is no side input"):
        replay_pipeline(settings(), ["nonsense"], None)


@pytest.mark.parametrize(("length", "rate"), [(511, 16_000), (512, 8_000), (0, 16_000)])
def test_a_block_that_is_no_frame_is_refused(length, rate):
    replayed = FakeReplay(CONFIG, FakeRecognizer(), None, SideInputs([]))
    with pytest.raises(NotReplayable, match=f"{length} samples at {rate} Hz, allowed: 512"):
        replayed.hear(Block(np.zeros(length, np.int16), rate, 0, 0.0))


def test_a_mode_can_be_taken_over_and_nonsense_not():
    replayed = FakeReplay(CONFIG, FakeRecognizer(), None, SideInputs([]))
    replayed.set_mode("active", "hey robot")
    assert replayed._pipeline.state.mode.value == "active"
    with pytest.raises(NotReplayable, match="allowed: standby, active"):
        replayed.set_mode("asleep", "")


def test_a_folder_of_recordings_loads_its_model_once(monkeypatch):
    loaded = []
    from voice_assist import recognizer

    def load(model, device):
        loaded.append(model)
        return FakeRecognizer()

    monkeypatch.setattr(recognizer, "load_recognizer", load)
    module._english.cache_clear()
    given = settings()
    given["spotter"]["is_enabled"] = False
    try:
        first, second = replay_pipeline(given, [], None), replay_pipeline(given, [], None)
    finally:
        module._english.cache_clear()
    assert loaded == ["embedded"] and first.model == second.model == "fake"


def test_a_stop_in_a_sentence_is_decided_again_as_the_robot_moved_then():
    sound = [
        replace(frame, is_moving=frame.stamp > 104.0)
        for frame in frames(say("he said stop now 3 he said stop now"))
    ]
    live = Live()
    first = next(frame for frame in sound if frame.is_moving)
    live.observe(SideInput(SideInputKind.MOVING, first.first_sample, is_moving=True))
    live.hear(sound)
    stops = [d for d in live.decisions if isinstance(d.outcome, Match)]
    assert [d.outcome.command for d in stops] == ["stop"]
    assert as_heard(again(live)) == as_decided(live.decisions)
    assert all(not heard.command for heard in again(live, notes=[]))


def test_a_session_in_another_language_is_replayed_by_what_heard_it(monkeypatch):
    made = []
    fake = FakeRecognizer()
    monkeypatch.setattr(module, "_of_another_language", lambda config: made.append(config) or fake)
    given = settings()
    given["spotter"].update(is_enabled=False)
    given["commands"] = load_yaml(CONFIG_DIR / "commands_de.yaml")
    assert replay_pipeline(given, [], None).warnings == ()
    assert [(c.commands.language, c.commands.max_behind) for c in made] == [("de", 20.0)]


def test_what_a_recording_in_another_language_lacks_is_taken_from_the_file_of_that_language():
    given = settings()
    given["commands"] = load_yaml(CONFIG_DIR / "commands_ja.yaml")
    del given["commands"]["max_behind"]
    config, warnings = restore_settings(given, None)
    assert config.commands.max_behind == 10.0
    assert warnings == ("setting commands.max_behind was not recorded; today's is 10.0",)


def test_a_recording_in_an_unknown_language_is_refused_with_those_there_are():
    given = settings()
    given["commands"]["language"] = "it"
    with pytest.raises(ConfigError, match="'it', allowed: en, de, es, fr, ja"):
        restore_settings(given, None)


def test_a_recording_from_before_there_were_languages_is_english_and_said_once():
    given = settings()
    for key in ("language", "said_twice"):
        del given["commands"][key]
    config, warnings = restore_settings(given, None)
    assert (config.commands.language, config.commands.said_twice, warnings) == ("en", False, ())
