# SPDX-License-Identifier: BSD-3-Clause
"""In which type of number the networks compute, and that what is heard stays the same."""

import numpy as np
import pytest
import torch
from torch import nn

from support.theatre_sound import speak
from voice_assist.assembly import _over_talk
from voice_assist.config import CONFIG_DIR, load_voice_config
from voice_assist.errors import ModelError
from voice_assist.profile.active import PersonalRecognizer
from voice_assist.recognizer.checkpoint import EMBEDDED_PATH, read_checkpoint
from voice_assist.recognizer.embedded import EmbeddedRecognizer, _Listening
from voice_assist.recognizer.precision import (
    AUTO,
    BFLOAT16,
    FLOAT32,
    dtype_for,
    in_one_call,
    quick,
)
from voice_assist.spotter.overlap import WINDOW, read_overlap
from voice_assist.types import frozen_samples

COMMANDS = load_voice_config(CONFIG_DIR).commands.fixed_phrases
in_bfloat16 = pytest.mark.skipif(
    dtype_for("cpu") != torch.bfloat16, reason="needs a processor that multiplies bfloat16"
)


@pytest.fixture(scope="module")
def recognizers():
    checkpoint = read_checkpoint(EMBEDDED_PATH)
    types = (torch.float32, torch.bfloat16)
    return [EmbeddedRecognizer("x", checkpoint, dtype=dtype) for dtype in types]


@pytest.mark.parametrize(
    ("has_it", "device", "precision", "expected"),
    [
        (True, "cpu", AUTO, torch.bfloat16),
        (True, "cpu", BFLOAT16, torch.bfloat16),
        (True, "cpu", FLOAT32, torch.float32),
        (False, "cpu", AUTO, torch.float32),
        (False, "cpu", FLOAT32, torch.float32),
        (True, "cuda", AUTO, torch.float32),
    ],
)
def test_auto_is_bfloat16_where_the_processor_has_it(
    monkeypatch, has_it, device, precision, expected
):
    monkeypatch.setattr(torch.cpu, "_is_avx512_bf16_supported", lambda: has_it)
    assert dtype_for(device, precision) == expected


@pytest.mark.parametrize(("has_it", "device"), [(False, "cpu"), (True, "cuda")])
def test_bfloat16_is_refused_where_it_cannot_be_had(monkeypatch, has_it, device):
    monkeypatch.setattr(torch.cpu, "_is_avx512_bf16_supported", lambda: has_it)
    refused = f"precision 'bfloat16' on {device}: .*avx512_bf16; allowed: auto, float32"
    with pytest.raises(ModelError, match=refused):
        dtype_for(device, BFLOAT16)


def test_in_float32_it_is_the_network_itself():
    network = nn.Sequential(nn.Linear(4, 3))
    assert quick(network, torch.float32) is network


def assert_rounds_only(network, x):
    """In bfloat16 it gives nearly the same, in single precision."""
    with torch.inference_mode():
        exact, found = network(x), quick(network, torch.bfloat16)(x)
    assert found.dtype == torch.float32
    assert found.shape == exact.shape
    error = (found - exact).abs().max() / exact.abs().max()
    assert 0.0 < error < 0.01


@in_bfloat16
@pytest.mark.parametrize("rows", [1, 20, 80, 500])
def test_a_linear_map_in_bfloat16_rounds_only(rows):
    torch.manual_seed(rows)
    network = nn.Sequential(nn.Linear(384, 1536), nn.GELU(), nn.Linear(1536, 384, bias=False))
    assert_rounds_only(network, torch.randn(1, rows, 384))


@in_bfloat16
@pytest.mark.parametrize(("width", "stride", "padding"), [(3, 1, 1), (3, 2, 1), (5, 1, 2)])
def test_a_convolution_in_bfloat16_rounds_only(width, stride, padding):
    torch.manual_seed(width + stride)
    layer = nn.Conv1d(80, 64, width, stride, padding)
    network = nn.Sequential(layer, nn.GELU(), nn.Conv1d(64, 2, width))
    assert_rounds_only(network, torch.randn(3, 80, 161))


@in_bfloat16
def test_all_other_weights_are_shared_and_no_map_is_left(recognizers):
    exact, rounded = recognizers
    assert exact.network is exact.model
    own = dict(rounded.model.named_parameters())
    kept = dict(rounded.network.named_parameters())
    assert set(kept) < set(own)
    assert all(weight is own[name] for name, weight in kept.items())
    maps = (nn.Linear, nn.Conv1d)
    assert not any(isinstance(module, maps) for module in rounded.network.modules())


@in_bfloat16
def test_every_command_is_written_and_scored_the_same(recognizers):
    for phrase in COMMANDS:
        said = np.pad(speak(phrase, "en-us", 150), 3200).astype(np.float32)
        exact, rounded = (r.transcribe(said) for r in recognizers)
        assert exact.text == rounded.text == phrase
        assert rounded.confidence == pytest.approx(exact.confidence, abs=0.02)
        before, after = (r.score(said, COMMANDS) for r in recognizers)
        assert after == pytest.approx(before, abs=0.5, rel=0.02)


@in_bfloat16
def test_the_spotter_over_talk_scores_the_same():
    exact, rounded = read_overlap()[0], _over_talk(BFLOAT16)[0]
    word = speak("stop", "en-us", 150)
    windows = [np.pad(word, (WINDOW - len(word) - late, late)) for late in (0, 1600, 8000)]
    with torch.inference_mode():
        sound = torch.from_numpy(np.stack(windows).astype(np.float32))
        before, after = exact(sound)[0], rounded(sound)[0]
    assert float(before.max()) > 3.0
    torch.testing.assert_close(after, before, atol=0.2, rtol=0.02)


@pytest.fixture(scope="module")
def in_single():
    return EmbeddedRecognizer("x", read_checkpoint(EMBEDDED_PATH), dtype=torch.float32)


@pytest.mark.parametrize("samples", [6400, 8001, 16_000, 40_000])
def test_what_is_heard_in_one_call_is_the_same_to_the_last_bit(in_single, samples):
    sound = 0.1 * torch.randn(1, samples, generator=torch.Generator().manual_seed(samples))
    with torch.inference_mode():
        one_by_one = list(_Listening(in_single.network)(sound))
        in_one = list(in_single._listening(sound))
    assert isinstance(in_single._listening, torch.jit.ScriptModule)
    assert len(in_one) == len(one_by_one) > 3
    assert all(map(torch.equal, in_one, one_by_one))


@pytest.mark.parametrize("windows", [1, 2, 4])
def test_so_is_the_opinion_on_any_number_of_windows_over_talk(windows):
    network = read_overlap()[0]
    in_one = in_one_call(network, torch.float32, torch.zeros(1, WINDOW))
    generator = torch.Generator().manual_seed(windows)
    with torch.inference_mode():
        sound = 0.1 * torch.randn(windows, WINDOW, generator=generator)
        assert all(map(torch.equal, in_one(sound), network(sound)))


def test_maps_in_bfloat16_are_called_one_by_one():
    network = nn.Linear(4, 4)
    assert in_one_call(network, torch.bfloat16, torch.zeros(1, 4)) is network


def test_a_profile_is_heard_by_its_own_weights(in_single):
    state = {name: 1.5 * weight for name, weight in in_single.model.ctc.state_dict().items()}
    own = PersonalRecognizer(in_single, {f"ctc.{name}": w for name, w in state.items()})
    sound = frozen_samples(0.1 * np.random.default_rng(0).standard_normal(16_000))
    with torch.inference_mode():
        base, personal = in_single._listen(sound), own._listen(sound)
        expected = own.network.ctc_logprobs(base.states)[0]
        assert in_single._listen(sound) is base  # one does not forget what the other hears
    assert torch.equal(personal.ctc, expected) and not torch.equal(personal.ctc, base.ctc)
