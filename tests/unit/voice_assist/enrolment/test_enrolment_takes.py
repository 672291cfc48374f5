# SPDX-License-Identifier: BSD-3-Clause
"""Which takes are kept: the checks, the script, and recordings that exist already."""

import dataclasses
import re
from functools import partial

import numpy as np
import pytest
import soundfile

from tests.unit.voice_assist.support.fake_speech import FakeRecognizer, say, silence, tone
from voice_assist.config import load_voice_config
from voice_assist.config.enrolment import load_enrolment_config
from voice_assist.enrolment.takes.checks import TakeCheck
from voice_assist.enrolment.takes.from_files import find_recordings, read_recordings
from voice_assist.enrolment.takes.recording import record
from voice_assist.enrolment.takes.script import GOOD, UNLIKE, EnrolmentScript, RecordedTake
from voice_assist.errors import AudioError, ManifestError
from voice_assist.profile.manifest import COMMAND, ROOM, TALK
from voice_assist.profile.profile import create_profile, open_profile
from voice_assist.types import RATE, Frame, frozen_samples

COMMANDS = load_voice_config().commands
CONFIG = load_enrolment_config()
CLICK = np.concatenate([silence(0.5), 0.3 * np.ones(1200), silence(0.5)])


def check(**scores):
    return TakeCheck(CONFIG.checks, COMMANDS, FakeRecognizer(scores))


said = partial(say, before=0.3, after=0.3)


def test_a_clear_take_is_good_and_says_what_it_is_like():
    checked = check()(COMMAND, "pull more", said("pull more"))
    assert checked.is_good
    assert checked.heard == "pull more"
    assert checked.seconds == pytest.approx(0.5, abs=0.1)
    assert checked.level_db == pytest.approx(-13.5, abs=1.0)
    assert checked.snr_db > 50.0


@pytest.mark.parametrize(
    ("change", "problem"),
    [
        (lambda s: 0.003 * s, r"too quiet: -\d+ dB of full scale, allowed: at least -45"),
        (lambda s: np.clip(20.0 * s, -1.0, 1.0), r"clipped: \d+.\d% .* allowed: up to 0.2%"),
        (lambda s: s[5000:], r"cut at the start: 0.0\d s before it, allowed: 0.05"),
        (lambda s: s[:-5200], r"cut at the end: 0.0\d s after it, allowed: 0.05"),
        (lambda s: s + noise(len(s), 0.09), r"too noisy: \d dB over the room, allowed: at least"),
        (lambda s: np.tile(s, 4), r"too long: \d.\d\d s of speech, allowed: up to 2.00"),
        (lambda s: CLICK, r"too short: 0.\d\d s of speech, allowed: at least 0.15"),
        (np.zeros_like, "too quiet"),
    ],
)
def test_a_bad_take_is_named_with_value_and_limit(change, problem):
    samples = np.asarray(change(said("tense release")), np.float32)
    checked = check()(COMMAND, "tense", samples)
    assert not checked.is_good
    assert not checked.is_other
    assert any(re.search(problem, found) for found in checked.problems), checked.problems


def test_another_command_is_a_wrong_word_unless_it_is_hardly_heard_as_in_an_accent():
    surely = check(**{"pull less": 9.0, "pull more": -30.0})
    hardly = check(**{"pull less": 0.5, "pull more": -0.5})
    checked = surely(COMMAND, "pull more", said("pull less"))
    assert checked.is_other
    words = "wrong word: 'pull less' was heard, by 9.0 nat, allowed: 'pull more'"
    assert words in checked.problems[0]
    assert hardly(COMMAND, "pull more", said("pull less")).is_good


def test_talk_needs_some_speech_and_the_room_none():
    assert check()(TALK, "", said("he said the not is what")).is_good
    quiet = np.concatenate([tone("now")[:1600], silence(5.0)]).astype(np.float32)
    assert "too little talk" in check()(TALK, "", quiet).problems[0]
    assert check()(ROOM, "", silence(3.0).astype(np.float32)).is_good


@pytest.fixture
def profile(tmp_path):
    return create_profile("ada", "ab" * 32, tmp_path / "profiles")


def session(profile, repetitions=3, talk=4.0, **scores):
    config = dataclasses.replace(CONFIG, repetitions=repetitions, talk=talk, talk_piece=2.0)
    return EnrolmentScript(profile, config, COMMANDS.phrases, check(**scores))


def follow(script, limit=100):
    """Do as the script asks."""
    asked = []
    while (step := script.next()) is not None and len(asked) < limit:
        asked.append(step.phrase or step.kind)
        if step.kind == COMMAND:
            sound = said(step.phrase)
        elif step.kind == TALK:
            sound = said("he said the not is what")[: 2 * RATE]
        else:
            sound = silence(step.seconds).astype(np.float32)
        script.offer(step, sound)
    return asked


def test_the_script_asks_for_the_room_the_commands_in_turns_and_talk(profile):
    asked = follow(session(profile))
    assert asked[0] == ROOM
    assert asked[1:8] == list(COMMANDS.phrases)
    assert asked[1:22] == list(COMMANDS.phrases) * 3
    assert set(asked[22:]) == {TALK}
    assert 2 <= len(asked[22:]) <= 3


def test_what_is_there_is_not_asked_again(profile):
    first = follow(session(profile), limit=9)
    again = open_profile("ada", profile.folder.parent)
    rest = follow(session(again))
    assert len(first) == 9
    assert [*first, *rest] == follow(
        session(create_profile("bob", "ab" * 32, profile.folder.parent))
    )


def test_a_wrong_word_is_never_kept(profile):
    script = session(profile, **{"stop": 9.0, "tense": -60.0})
    step = script.next()
    script.offer(step, silence(3.0).astype(np.float32))
    step = dataclasses.replace(step, kind=COMMAND, phrase="tense")
    for _ in range(5):
        assert script.offer(step, said("stop")).is_other
    assert [take.kind for take in profile.manifest.takes] == [ROOM]


def test_what_is_unlike_twice_is_how_the_person_says_it(profile):
    script = session(profile, tense=-60.0)
    step = dataclasses.replace(script.next(), kind=COMMAND, phrase="tense")
    assert script.offer(step, said("mumble")).is_unlike
    assert not profile.manifest.takes
    script.offer(step, said("mumble"))
    assert [take.verdict for take in profile.manifest.takes] == [UNLIKE]
    script.offer(step, said("tense"))
    assert [take.verdict for take in profile.manifest.takes] == [UNLIKE, GOOD]


def write(folder, name, sound):
    folder.mkdir(exist_ok=True)
    soundfile.write(folder / name, sound, RATE)


def test_recordings_are_taken_over_by_their_names_once(profile, tmp_path):
    folder = tmp_path / "wavs"
    write(folder, "pull_more-1.wav", said("pull more"))
    write(folder, "stop-2.flac", said("stop"))
    write(folder, "talk-1.wav", said("he said the not is what"))
    write(folder, "tense.wav", 0.001 * said("tense"))
    found = find_recordings(folder, COMMANDS.phrases)
    checked = []
    script = session(profile)
    takes = read_recordings(found)
    assert script.take_over(takes, lambda name, _: checked.append(name)) == 3
    kept = {(take.kind, take.phrase) for take in profile.manifest.takes}
    assert kept == {(COMMAND, "pull more"), (COMMAND, "stop"), (TALK, "")}
    assert checked == ["pull_more-1.wav", "stop-2.flac", "talk-1.wav", "tense.wav"]
    assert script.take_over(read_recordings(found), lambda *_: None) == 0


def test_recordings_of_one_name_and_length_are_all_taken_over(profile, tmp_path):
    rows = ["path,transcript"]
    for phrase in ("stop", "now", "tense"):
        sound = np.zeros(2 * RATE, np.float32)
        sound[: len(said(phrase))] = said(phrase)
        write(tmp_path / phrase, "1.wav", sound)
        rows.append(f"{phrase}/1.wav,{'' if phrase == 'now' else phrase}")
    (tmp_path / "takes.csv").write_text("\n".join(rows) + "\n")
    found = find_recordings(tmp_path, COMMANDS.phrases)
    offered = []
    script = session(profile)
    script.take_over(read_recordings(found), lambda name, _: offered.append(name))
    assert offered == ["1.wav"] * 3
    kept = [take.phrase for take in profile.manifest.takes]
    assert {"stop", "tense"} <= set(kept)
    script.take_over(read_recordings(found), lambda *_: None)
    assert [take.phrase for take in profile.manifest.takes] == kept


def test_a_list_says_what_is_in_which_recording(tmp_path):
    folder = tmp_path / "wavs"
    write(folder, "a.wav", said("tense"))
    write(folder, "b.wav", said("now"))
    (folder / "takes.csv").write_text("path,transcript\na.wav,Tense!\nb.wav,\n")
    found = find_recordings(folder, COMMANDS.phrases)
    listed = [(r.path.name, r.kind, r.phrase) for r in found]
    assert listed == [("a.wav", COMMAND, "tense"), ("b.wav", TALK, "")]


def test_a_phrase_with_accents_is_known_by_its_words(tmp_path):
    write(tmp_path, "arretez-1.wav", said("stop"))
    write(tmp_path, "arrêtez-2.wav", said("stop"))
    found = find_recordings(tmp_path, load_voice_config(language="fr").commands.phrases)
    assert [r.phrase for r in found] == ["arrêtez", "arrêtez"]


def test_a_recording_of_no_command_is_named(tmp_path):
    folder = tmp_path / "wavs"
    write(folder, "banana-1.wav", said("now"))
    with pytest.raises(ManifestError, match=r"banana-1.wav: 'banana' is no command, allowed: hey"):
        find_recordings(folder, COMMANDS.phrases)
    with pytest.raises(ManifestError, match="no such folder"):
        find_recordings(tmp_path / "none", COMMANDS.phrases)


def test_all_that_stands_behind_the_first_hyphen_says_nothing(tmp_path):
    for name in ("pull_more-2024-11-03.wav", "hey_robot-a-b.WAV", "stop.wav"):
        write(tmp_path, name, said("now"))
    found = find_recordings(tmp_path, COMMANDS.phrases)
    assert [r.phrase for r in found] == ["hey robot", "pull more", "stop"]


def test_a_file_that_is_left_out_is_named_with_the_reason(tmp_path):
    for name in ("talk-1.aiff", "-1.wav"):
        write(tmp_path, name, said("now"))
    (tmp_path / "tense-1.m4a").touch()
    (tmp_path / "old").mkdir()
    endings = r"allowed: \.wav, \.flac, \.ogg, \.opus, \.mp3"
    reasons = (
        r"-1\.wav is left out: no command stands in front of its hyphen",
        r"old is left out: it is no file",
        rf"talk-1\.aiff is left out: its ending is '\.aiff', {endings}",
        rf"tense-1\.m4a is left out: its ending is '\.m4a', {endings}",
    )
    left_out = []
    with pytest.raises(ManifestError, match="no recordings in it, allowed: names such as pull_mo"):
        find_recordings(tmp_path, COMMANDS.phrases, left_out.append)
    write(tmp_path, "stop-1.wav", said("stop"))
    (found,) = find_recordings(tmp_path, COMMANDS.phrases, left_out.append)
    assert found.path.name == "stop-1.wav"
    assert len(left_out) == 2 * len(reasons)
    assert all(map(re.fullmatch, reasons * 2, left_out)), left_out


def test_what_nobody_can_read_in_the_name_of_a_recording_is_replaced(profile):
    recorded = RecordedTake("st\u200eop\udcff-1.wav", COMMAND, "stop", said("stop"))
    assert session(profile).take_over([recorded], lambda *_: None) == 1
    (take,) = open_profile("ada", profile.folder.parent).manifest.takes
    assert take.source == "st?op?-1.wav"


def test_a_take_with_a_gap_is_not_recorded():
    frames = [Frame(frozen_samples(np.zeros(512)), n, 0.0) for n in (0, 512, 2048)]
    levels = []
    with pytest.raises(AudioError, match="1024 samples of sound were lost"):
        record(iter(frames), 0.1, lambda level, done: levels.append(done))
    assert levels == pytest.approx([0.32, 0.64])
    with pytest.raises(AudioError, match="ended in the middle"):
        record(iter(frames[:2]), 0.1, lambda level, done: None)


def noise(length, level):
    return np.asarray(level * np.random.default_rng(2).standard_normal(length), np.float32)
