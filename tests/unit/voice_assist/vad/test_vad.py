# SPDX-License-Identifier: BSD-3-Clause
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from support.theatre_sound import speak
from tests.unit.voice_assist.support.fake_speech import frames, say, silence
from voice_assist.config import load_voice_config
from voice_assist.types import RATE
from voice_assist.vad.detector import EitherDetector, EnergyDetector, make_detector
from voice_assist.vad.endpointer import Endpointer, SpeechState
from voice_assist.vad.segmenter import Segmenter, last
from voice_assist.vad.silero import SileroDetector

CONFIG = load_voice_config(
    audio__vad__start=0.5,
    audio__vad__stop=0.3,
    audio__vad__resume=0.5,
    audio__vad__min_speech=0.06,
    audio__vad__hangover=0.32,
    audio__vad__max_utterance=2.0,
).audio.vad
FRAME = 0.032


def analyze(probabilities, config=CONFIG):
    analyzer = Endpointer(config)
    return [analyzer(p, FRAME) for p in probabilities]


def test_a_click_is_no_utterance():
    ends = analyze([0.0, 0.9, 0.0, 0.0])
    assert [e.state for e in ends][1] is SpeechState.STARTING
    assert not any(e.is_start for e in ends)
    assert ends[-1].state is SpeechState.QUIET


@pytest.mark.parametrize(
    ("probabilities", "end"),
    [
        ([0.9] * 5 + [0.0] * 12, 5 + 9),  # after the hangover
        ([0.9] * 3 + [0.3] * 20, None),  # the lower threshold holds it
    ],
)
def test_speech_starts_after_its_least_length_and_ends_after_the_hangover(probabilities, end):
    ends = analyze(probabilities)
    assert [e.is_start for e in ends].index(True) == 1
    assert [n for n, e in enumerate(ends) if e.is_end] == ([] if end is None else [end])
    assert all(e.state is SpeechState.SPEAKING for e in ends[2:]) is (end is None)
    assert end is None or ends[end].state is SpeechState.QUIET


def test_a_short_pause_does_not_end_an_utterance():
    ends = analyze([0.9] * 5 + [0.0] * 5 + [0.9] * 5)
    assert sum(e.is_start for e in ends) == 1
    assert not any(e.is_end for e in ends)
    assert ends[9].state is SpeechState.STOPPING
    assert ends[9].quiet == pytest.approx(5 * FRAME)
    assert ends[10].quiet == 0.0


def test_the_lower_threshold_does_not_start_speech():
    assert all(e.state is SpeechState.QUIET for e in analyze([0.4] * 20))


FAINT = load_voice_config(
    audio__vad__start=0.2, audio__vad__stop=0.35, audio__vad__resume=0.4, audio__vad__hangover=0.32
).audio.vad


@pytest.mark.parametrize(
    ("probabilities", "end"),
    [
        ([0.3] * 3 + [0.12] * 20 + [0.09] * 12, 23 + 9),  # held by its own measure, and ends by it
        ([0.9] * 3 + [0.3] * 12, 3 + 9),  # clear speech is not held by what holds faint speech
        ([0.3] * 3 + [0.9] + [0.3] * 12, 4 + 9),  # it became clear
    ],
)
def test_speech_is_held_by_a_share_of_its_highest_probability(probabilities, end):
    ends = analyze(probabilities, FAINT)
    assert [e.is_end for e in ends].index(True) == end
    assert all(e.state is SpeechState.SPEAKING for e in ends[2 : end - 9])


def test_one_sure_frame_and_fainter_ones_are_speech():
    assert any(e.is_start for e in analyze([0.0] * 3 + [0.36, 0.14], FAINT))
    assert not any(e.is_start for e in analyze([0.0] * 3 + [0.36, 0.1, 0.36, 0.1], FAINT))


def test_an_utterance_is_not_measured_by_the_one_before_it():
    ends = analyze([0.9] * 3 + [0.0] * 12 + [0.3] * 3 + [0.12] * 20, FAINT)
    assert all(e.state is SpeechState.SPEAKING for e in ends[-20:])


def test_the_highest_probability_of_an_utterance_and_the_time_since_its_begin_are_given():
    ends = analyze([0.9] * 3 + [0.0] * 12 + [0.2, 0.7, 0.6, 0.8], FAINT)
    assert [e.clearness for e in ends[-4:]] == [0.2, 0.7, 0.7, 0.8]
    ends = analyze([0.0] * 3 + [0.9] * 5)
    assert ends[-1].spoken == pytest.approx(5 * FRAME)


@given(st.lists(st.floats(0.0, 1.0), max_size=200))
def test_starts_and_ends_take_turns(probabilities):
    inside = False
    for end in analyze(probabilities):
        if end.is_start:
            assert not inside
            inside = True
        if end.is_end:
            assert inside
            inside = False
        assert inside == (end.state in (SpeechState.SPEAKING, SpeechState.STOPPING))


def cut(sound, cutter=None):
    """How an utterance grows."""
    cutter, analyzer, detector = cutter or Segmenter(CONFIG), Endpointer(CONFIG), EnergyDetector(12)
    for frame in frames(sound):
        if growth := cutter(frame, analyzer(detector(frame.samples), frame.duration)):
            yield growth


def test_an_utterance_grows_to_its_end_and_holds_what_was_before_it():
    growths = list(cut(say("tense")))
    lengths = [len(g.utterance.samples) for g in growths]
    assert lengths == sorted(lengths)
    assert [g.utterance.is_complete for g in growths] == [False] * (len(growths) - 1) + [True]
    loud = np.flatnonzero(np.abs(growths[-1].utterance.samples) > 0.01)
    assert loud[0] / RATE == pytest.approx(CONFIG.pre_roll, abs=0.07)
    assert (loud[-1] - loud[0]) / RATE == pytest.approx(0.22, abs=0.01)


def test_the_sound_of_an_utterance_is_that_of_the_stream():
    sound = say("tense")
    *_, whole = cut(sound)
    heard = whole.utterance.samples
    start = int(np.argmax(np.convolve(sound, heard[::-1], "valid")))
    np.testing.assert_allclose(heard, sound[start : start + len(heard)], atol=2e-5)


def test_talk_without_end_is_cut_and_its_rest_is_not_whole():
    growths = list(cut(say("tense " * 20)))
    complete = [g for g in growths if g.utterance.is_complete]
    assert len(complete) >= 2
    assert [g.is_whole for g in complete] == [True] + [False] * (len(complete) - 1)
    assert max(len(g.utterance.samples) for g in growths) <= 2.0 * RATE + 512


def test_after_a_restart_only_the_rest_is_left():
    cutter = Segmenter(CONFIG)
    growths = cut(say("tense"), cutter)
    next(growths)
    cutter.restart(keep=0.064)
    first, *rest = growths
    assert len(first.utterance.samples) == 3 * 512
    assert not any(growth.is_whole for growth in (first, *rest))


def test_the_newest_part_of_sound():
    samples = np.arange(RATE, dtype=np.float32)
    assert last(samples, 0.5)[0] == RATE / 2
    assert len(last(samples, 9.0)) == RATE


@pytest.mark.parametrize("others", [(), (EnergyDetector(60.0),)])
def test_energy_takes_a_loud_burst_for_speech_and_a_quiet_room_for_none(others):
    detector = EnergyDetector(9.0)
    detector = EitherDetector(*others, detector) if others else detector  # the surer counts
    sure = [detector(f.samples) for f in frames(say("tense"))]
    assert max(sure) > 0.99
    assert sure[0] < 0.1 and sure[-1] < 0.1
    detector.reset()


def test_energy_gets_used_to_a_steady_fan():
    detector = EnergyDetector(9.0)
    fan = 0.05 * np.random.default_rng(0).standard_normal(RATE * 25)
    sure = [detector(f.samples) for f in frames(np.r_[silence(1.0), fan].astype(np.float32))]
    assert sure[40] > 0.9
    assert max(sure[-50:]) < 0.1


def test_silero_hears_no_speech_in_noise_and_keeps_the_threads_of_torch():
    import torch

    threads = torch.get_num_threads()
    torch.set_num_threads(2)
    try:
        detector = make_detector(load_voice_config().audio.vad)
        assert torch.get_num_threads() == 2
    finally:
        torch.set_num_threads(threads)
    noise = 0.02 * np.random.default_rng(0).standard_normal(RATE)
    heard = [detector(f.samples) for f in frames(noise.astype(np.float32))]
    assert max(heard) < load_voice_config().audio.vad.start
    with pytest.raises(ValueError, match="allowed: 512"):
        detector(np.zeros(100, np.float32))


def test_silero_is_as_sure_as_its_own_package_is():
    import torch

    threads = torch.get_num_threads()
    from silero_vad import load_silero_vad

    torch.set_num_threads(threads)  # the package has changed it
    its_own, detector = load_silero_vad(), SileroDetector()
    sound = frames(np.r_[silence(0.3), speak("pull more", "en-us", 150), silence(0.3)])
    with torch.inference_mode():
        expected = [float(its_own(torch.tensor(frame.samples), RATE)) for frame in sound]
    found = [detector(frame.samples) for frame in sound]
    assert min(expected) < 0.1 < 0.9 < max(expected)
    np.testing.assert_allclose(found, expected, atol=1e-5)


def test_silero_gives_the_same_again_after_a_reset():
    detector = SileroDetector()
    sound = frames(0.1 * np.random.default_rng(0).standard_normal(8000).astype(np.float32))
    first = [detector(f.samples) for f in sound]
    detector.reset()
    assert [detector(f.samples) for f in sound] == first
