# SPDX-License-Identifier: BSD-3-Clause
"""Motion in the enrolled voice only; "stop" from anyone, whatever the gate says."""

from dataclasses import replace

import numpy as np
import pytest

from support.theatre_sound import speak
from tests.unit.voice_assist.support.fake_pipeline import decisions, hear
from voice_assist.config import load_voice_config
from voice_assist.errors import ModelError
from voice_assist.speaker import gate as gates
from voice_assist.speaker import network
from voice_assist.speaker.cohort import Cohort, read_cohort
from voice_assist.speaker.gate import ClosedGate, SpeakerGate, make_gate
from voice_assist.speaker.network import WIDTH, VoiceNetwork, unit
from voice_assist.speaker.speech import piece_up, spoken
from voice_assist.speaker.voiceprint import Voiceprint, VoiceprintError, make_voiceprint
from voice_assist.types import (
    RATE,
    Call,
    Halt,
    Match,
    Mode,
    NoMatch,
    Rejection,
    RejectionReason,
    frozen_samples,
)

CONFIG = load_voice_config(speaker__gate="on").speaker
MOTIONS = ("tense", "release", "pull more", "pull less")
OTHERS = ("hey robot", "stop", "terminate")


def decided(text, gate, mode=Mode.ACTIVE):
    return decisions(hear(text, mode, gate=gate))


def nobody(samples):
    return Rejection(RejectionReason.OTHER_VOICE, "not this voice: score 0.1")


def anybody(samples):
    return None


@pytest.mark.parametrize("phrase", MOTIONS)
def test_a_motion_in_the_enrolled_voice_moves_and_in_another_it_is_refused_by_name(phrase):
    (decision,) = decided(phrase, anybody)
    assert decision.outcome.command == phrase and Call(phrase) in decision.actions
    (decision,) = decided(phrase, nobody)
    assert isinstance(decision.outcome, NoMatch) and decision.outcome.nearest_command == phrase
    assert decision.outcome.rejection.words.startswith("not this voice") and not decision.actions


@pytest.mark.parametrize("gate", [nobody, ClosedGate("the model is missing")])
@pytest.mark.parametrize("phrase", OTHERS)
def test_what_moves_nothing_is_taken_from_any_voice(phrase, gate):
    (decision,) = decided(phrase, gate)
    assert isinstance(decision.outcome, Match) and decision.outcome.command == phrase


@pytest.mark.parametrize("mode", Mode)
def test_a_stop_never_asks_the_gate(mode):
    def never(samples):
        raise AssertionError("a stop waited for the gate")

    for text in ("stop", "please stop", "stop stop", "mumble 1.0 stop"):
        assert any(Halt() in d.actions for d in decided(text, never, mode)), text


def test_a_gate_that_cannot_judge_refuses_motion_with_its_reason():
    (decision,) = decided("tense", ClosedGate("the model is missing"))
    assert "cannot judge: the model is missing" in decision.outcome.rejection.words


def test_what_moves_nothing_anyway_is_refused_for_its_own_reason():
    for text in ("do not pull more", "what he said", "tense"):
        mode = Mode.STANDBY if text == "tense" else Mode.ACTIVE
        for decision in decided(text, anybody, mode):
            assert isinstance(decision.outcome, NoMatch) and not decision.actions


def test_the_gate_hears_the_utterance_and_judges_it_once():
    heard = []

    def gate(samples):
        heard.append(len(spoken(samples)) / RATE)
        return None

    decided("tense", gate)
    assert heard and min(heard) > 0.15


# The parts of the gate.


def voice(angle, rng, wobble=0.3):
    """A point near a direction in a plane of the embedding's sphere."""
    point = np.zeros(WIDTH)
    point[:2] = np.cos(angle), np.sin(angle)
    return unit(point + wobble * rng.standard_normal(WIDTH) / np.sqrt(WIDTH))


@pytest.fixture
def cohort():
    rng = np.random.default_rng(1)
    return Cohort(np.array([[voice(a, rng) for _ in range(4)] for a in np.linspace(0.8, 6.0, 120)]))


def embed_as(angle, seed=2):
    """A network that hears one voice in every sound, and embeds it near an angle."""
    rng = np.random.default_rng(seed)
    return lambda samples: voice(angle, rng)


def noise(seconds, seed=3):
    return np.random.default_rng(seed).standard_normal(round(seconds * RATE)).astype(np.float32)


def print_of(angle, cohort):
    return make_voiceprint([0.1 * noise(1.0)] * 8, embed_as(angle), cohort, "d", CONFIG)


def test_a_voiceprint_lets_its_own_voice_through_and_no_other(cohort):
    known = print_of(0.0, cohort)
    assert known.missed == 0.0 and known.takes == 8
    own = SpeakerGate(known, embed_as(0.0, 5), cohort, CONFIG)
    other = SpeakerGate(known, embed_as(1.5, 5), cohort, CONFIG)
    assert own(frozen_samples(noise(1.0))) is None
    assert "not this voice: score" in other(frozen_samples(noise(1.0))).words


def test_the_share_of_background_voices_let_through_is_what_was_asked_for(cohort):
    known = print_of(0.0, cohort)
    scores = cohort.impostors(known.centre)
    assert (scores >= known.threshold).mean() == pytest.approx(CONFIG.false_accept, abs=0.005)


def test_a_score_that_is_no_number_and_a_network_that_raises_refuse(cohort):
    def broken(samples):
        raise RuntimeError("out of memory")

    known, sound = print_of(0.0, cohort), frozen_samples(noise(1.0))
    assert "failed" in SpeakerGate(known, broken, cohort, CONFIG)(sound).words
    known = replace(known, threshold=float("nan"))
    assert SpeakerGate(known, embed_as(0.0), cohort, CONFIG)(sound)


def test_too_little_speech_is_refused_with_the_limit(cohort):
    gate = SpeakerGate(print_of(0.0, cohort), embed_as(0.0), cohort, CONFIG)
    assert "0.25 s" in gate(frozen_samples(noise(0.1))).words
    assert "too short" in gate(frozen_samples(np.zeros(RATE))).words


def test_a_voice_like_many_others_and_too_few_takes_give_no_voiceprint(cohort):
    rng = np.random.default_rng(4)
    anyone = lambda samples: voice(rng.uniform(1, 6), rng)  # noqa: E731
    with pytest.raises(VoiceprintError, match="of its own takes, allowed: up to 25%"):
        make_voiceprint([noise(1.0)] * 8, anyone, cohort, "d", CONFIG)
    with pytest.raises(VoiceprintError, match=r"3 takes with 3\.0 s of speech"):
        make_voiceprint([noise(1.0)] * 3, embed_as(0.0), cohort, "d", CONFIG)


def test_a_voiceprint_survives_its_file_and_a_damaged_one_is_refused(cohort):
    known = print_of(0.0, cohort)
    again = Voiceprint.from_bytes(known.to_bytes())
    np.testing.assert_allclose(again.centre, known.centre)
    assert again.threshold == known.threshold and again.cohort == "d"
    for data in (b"", b"x" * 500, known.to_bytes()[:-200]):
        with pytest.raises(VoiceprintError):
            Voiceprint.from_bytes(data)


def test_a_gate_that_is_off_is_none_and_one_without_a_profile_stays_closed():
    assert make_gate(load_voice_config().speaker, None) is None
    closed = make_gate(CONFIG, None)
    assert "no profile with a voiceprint" in closed(frozen_samples(noise(1.0))).words
    assert "cannot be read" in make_gate(CONFIG, b"damaged")(frozen_samples(noise(1.0))).words


def test_a_gate_of_another_background_or_without_its_network_stays_closed(cohort, monkeypatch):
    def missing():
        raise ModelError("speaker.pt cannot be read")

    known, sound = print_of(0.0, cohort), frozen_samples(noise(1.0))
    assert "other background voices" in make_gate(CONFIG, known.to_bytes())(sound).words
    monkeypatch.setattr(gates, "VoiceNetwork", missing)
    data = replace(known, cohort=read_cohort()[1]).to_bytes()
    assert "speaker.pt" in make_gate(CONFIG, data)(sound).words


# The real network and background.


def test_the_network_gives_unit_vectors_whatever_the_length_and_level():
    embed = VoiceNetwork()
    for seconds in (0.25, 1.0, 4.0):
        point = embed(0.1 * noise(seconds))
        assert point.shape == (WIDTH,) and np.linalg.norm(point) == pytest.approx(1.0)
    loud, soft = embed(0.02 * noise(1.0)), embed(0.002 * noise(1.0))
    np.testing.assert_allclose(loud, soft, atol=1e-4)


def test_weights_that_are_missing_or_others_are_refused(tmp_path, monkeypatch):
    other = bytearray(network.WEIGHTS.read_bytes())
    other[len(other) // 2] ^= 1
    (tmp_path / "other.pt").write_bytes(other)
    for name, word in (("missing.pt", "cannot be read"), ("other.pt", "")):
        monkeypatch.setattr(network, "WEIGHTS", tmp_path / name)
        with pytest.raises(ModelError, match=rf"{name}.*{word}"):
            VoiceNetwork()


def test_several_are_heard_as_one_by_one():
    embed = VoiceNetwork()
    sounds = [0.1 * noise(seconds, seed) for seed, seconds in enumerate((0.3, 1.0, 0.3, 4.0))]
    one_by_one = np.stack([embed(sound) for sound in sounds])
    np.testing.assert_allclose(embed.many(sounds), one_by_one, atol=1e-5)
    assert np.abs(one_by_one @ one_by_one.T - np.eye(4)).max() > 1e-3  # they differ


def test_the_shipped_background_is_of_many_speakers_without_sound_and_a_damaged_one_refused(
    tmp_path,
):
    cohort, digest = read_cohort()
    assert cohort.pieces.shape[0] > 200 and cohort.pieces.shape[1:] == (4, WIDTH)
    assert len(digest) == 64
    path = tmp_path / "cohort.npz"
    for write in (lambda: None, lambda: path.write_bytes(b"x"), lambda: np.savez(path, pieces=[1])):
        write()
        with pytest.raises(ModelError):
            read_cohort(path)


def test_pauses_are_no_speech_and_pieces_are_equal():
    word = 0.1 * noise(0.5)
    sound = np.concatenate([np.zeros(8000), word, np.zeros(16000), word]).astype(np.float32)
    assert 0.9 * RATE < len(spoken(sound)) < 1.3 * RATE
    assert len(spoken(np.zeros(1000, np.float32))) == 0
    assert [len(p) for p in piece_up(word, 0.3)] == [4000, 4000]


@pytest.mark.parametrize("offset", [-0.03, 0.003, 0.01])
def test_an_offset_of_the_card_makes_no_speech_of_pauses_and_changes_no_voice(offset):
    word, quiet = speak("release", "en-us", 150).astype(float), np.zeros(8000)
    sound = np.concatenate([quiet, 0.1 * word / np.abs(word).max(), quiet])
    sound += 3e-4 * np.random.default_rng(5).standard_normal(len(sound))
    plain, shifted = spoken(sound), spoken(sound + offset)
    assert abs(len(shifted) - len(plain)) <= 320 and len(plain) < len(word)
    embed = VoiceNetwork()
    assert embed(plain) @ embed(shifted) > 0.99
    assert len(spoken(np.full(8000, offset))) == 0
