# SPDX-License-Identifier: BSD-3-Clause
"""Adapted weights: what is trained, what stays, and which files are refused."""

import dataclasses

import numpy as np
import pytest
import torch

from voice_assist.config.enrolment import load_enrolment_config
from voice_assist.enrolment.adapt import adapt, trained_names
from voice_assist.enrolment.examples import GRID, LONGEST, Example, broken_off, varied
from voice_assist.errors import ModelError
from voice_assist.profile import model_file
from voice_assist.profile.active import PersonalRecognizer
from voice_assist.types import RATE, frozen_samples

CONFIG = dataclasses.replace(load_enrolment_config().adapt, steps=3, batch=4)


def buzz(pitch, seconds=0.6):
    time = np.arange(round(seconds * RATE)) / RATE
    return np.asarray(0.3 * np.sign(np.sin(2 * np.pi * pitch * time)), np.float32)


def examples(text, pitch):
    rng = np.random.default_rng(0)
    return [varied(Example(buzz(pitch), text), rng) for _ in range(4)]


def test_only_what_lies_above_the_frozen_blocks_changes_and_the_same_each_time(base):
    before = {name: value.clone() for name, value in base.model.state_dict().items()}
    learned = examples("tense", 120.0), examples("no", 300.0)
    adapted, again = (adapt(base.model, *learned, CONFIG) for _ in range(2))
    assert all(torch.equal(adapted.state[name], again.state[name]) for name in adapted.state)
    assert set(adapted.state) == set(trained_names(base.model, CONFIG.frozen_blocks))
    assert not any("blocks.0" in name for name in adapted.state if "encoder" in name)
    assert not any("embedding" in name for name in adapted.state)
    assert any(not torch.equal(adapted.state[name], before[name]) for name in adapted.state)
    after = base.model.state_dict()
    assert all(torch.equal(after[name], before[name]) for name in before)


def test_the_personal_recogniser_hears_differently_and_the_base_as_before(
    base,
):
    sound = frozen_samples(buzz(150.0))
    before = base.transcribe(sound)
    changed = {name: torch.randn_like(base.model.get_parameter(name)) for name in ("ctc.weight",)}
    personal = PersonalRecognizer(base, changed, "ada", "cd" * 32)
    scores = personal.score(sound, ["stop", "tense"])  # heard anew, not what the base remembers
    assert scores != base.score(sound, ["stop", "tense"])
    assert base.transcribe(sound) == before
    assert (personal.model_hash, personal.profile) == (base.model_hash, "ada")


def test_weights_come_back_from_their_file(base):
    state = {"ctc.bias": torch.arange(29.0) / 8.0}
    data = model_file.to_bytes(state, base.model_hash)
    read = model_file.read_model(data, base.model, base.model_hash)
    assert torch.equal(read["ctc.bias"], state["ctc.bias"])


@pytest.mark.parametrize(
    ("state", "problem"),
    [
        ({"ctc.bias": torch.zeros(7)}, r"has the shape \(7,\), allowed: \(29,\)"),
        ({"ctc.bias": torch.full((29,), float("nan"))}, "29 NaN or infinite"),
        ({"ctc.bias": torch.zeros(29), "other": torch.zeros(1)}, "1 unknown, such as other"),
        ({}, "no tensor of the recogniser in it"),
    ],
)
def test_weights_that_do_not_fit_are_refused(base, state, problem):
    data = model_file.to_bytes(state, base.model_hash)
    with pytest.raises(ModelError, match=problem):
        model_file.read_model(data, base.model, base.model_hash)


def test_damaged_weights_and_those_of_another_base_are_refused(base):
    other = model_file.to_bytes({"ctc.bias": torch.zeros(29)}, "cd" * 32)
    with pytest.raises(ModelError, match="belongs to the base cdcdcdcdcdcd, allowed: "):
        model_file.read_model(other, base.model, base.model_hash)
    for data in (b"", b"PK\x03\x04", b"no archive at all"):
        with pytest.raises(ModelError):
            model_file.read_model(data, base.model, base.model_hash)


def test_a_varied_take_says_the_same_on_the_grid():
    rng = np.random.default_rng(3)
    for seconds in (0.3, 1.0, 6.0):
        found = varied(Example(buzz(200.0, seconds), "stop"), rng)
        assert found.text == "stop"
        assert len(found.samples) % GRID == 0
        assert len(found.samples) <= LONGEST
        assert 0.05 < float(np.abs(found.samples).max()) < 1.0


def test_a_broken_off_take_holds_the_beginning_and_its_letters(base):
    whole = Example(buzz(200.0, 1.0), "terminate")
    rng = np.random.default_rng(0)
    cut = [part for _ in range(8) if (part := broken_off(base.model, whole, rng)) is not None]
    assert cut
    for part in cut:
        assert "terminate".startswith(part.text)
        assert part.text != "terminate"
        assert len(part.samples) < len(whole.samples)
        np.testing.assert_array_equal(part.samples, whole.samples[: len(part.samples)])
