# SPDX-License-Identifier: BSD-3-Clause
"""A trained model: its export, small vocabulary, decoding, likelihoods and fine-tuning."""

import numpy as np
import pytest
import torch
import whisper

from tests.unit.voice_assist.support.small_recognizer import small_model, sound, whisper_file
from voice_assist.errors import ModelError
from voice_assist.recognizer.checkpoint import read_checkpoint
from voice_assist.recognizer.ctc import best_alignment, greedy_text
from voice_assist.recognizer.embedded import MAX_ROUNDS, EmbeddedRecognizer, _Listened, restore
from voice_assist.recognizer.mel import log_mel
from voice_assist.recognizer.scoring import ctc_likelihoods, decoder_likelihoods
from voice_assist.recognizer.vocabulary import (
    BLANK,
    CHARACTERS,
    IDS_BY_SIZE,
    PROMPT,
    WHISPER_IDS,
    decode,
    encode,
)
from voice_assist.training.data import texts
from voice_assist.training.data.batches import IGNORED, teacher_tensors
from voice_assist.training.data.voices import Prompt, speak
from voice_assist.training.fit.curriculum import CONTINUED, WRITING, stage_of
from voice_assist.training.fit.export import export
from voice_assist.training.fit.start import start_from
from voice_assist.types import RATE, frozen_samples, never_hopeless


@pytest.fixture(scope="module")
def model():
    return small_model()


@pytest.fixture(scope="module")
def exported(model, tmp_path_factory):
    path = tmp_path_factory.mktemp("export") / "model.pt"
    export(model, path)
    return path


def states_of(net, seconds=1.0, seed=0):
    """What the encoder makes of a sound."""
    return net.encode(log_mel(torch.from_numpy(sound(seconds, seed))[None]))


def test_exported_full_softmax_equals_the_training_softmax(exported):
    full = whisper.load_model(str(exported), device="cpu")
    compact = restore(read_checkpoint(exported)).eval()
    states = states_of(compact)
    ids = [*PROMPT, *encode("stop")]
    whisper_ids = torch.tensor([[WHISPER_IDS[index] for index in ids]])
    wide = full.decoder(whisper_ids, states)[0].log_softmax(-1)
    narrow = compact.logits(torch.tensor([ids]), states)[0].log_softmax(-1)
    used = list(WHISPER_IDS)
    torch.testing.assert_close(wide[:, used], narrow[:, : len(used)], atol=2e-4, rtol=1e-4)


@pytest.mark.parametrize(
    ("is_multilingual", "ids"), [(False, WHISPER_IDS), (True, IDS_BY_SIZE[51865])]
)
def test_compact_ids_are_whispers_tokens(is_multilingual, ids):
    tokenizer = whisper.tokenizer.get_tokenizer(multilingual=is_multilingual)
    characters = [tokenizer.encoding.encode_single_token(c) for c in CHARACTERS]
    special = [tokenizer.eot, tokenizer.sot, tokenizer.no_timestamps, tokenizer.no_speech]
    assert [*characters, *special] == list(ids)


def greedy(net, states, letters):
    """Greedy decoding one letter at a time, and whether it ended by itself."""
    ids = []
    for _ in range(letters):
        tokens = torch.tensor([[*PROMPT, *ids]])
        best = int(net.logits(tokens, states)[0, -1].argmax())
        if best == BLANK:  # the id of END in the compact vocabulary
            return ids, True
        ids.append(best)
    return ids, False


def written(recognizer, states, draft):
    """What is written of states with that draft, read for the first time."""
    memory = recognizer.network.remember(states)
    heard = _Listened(np.zeros(0), states, states, torch.zeros(0), draft, memory)
    return recognizer._decode(heard, never_hopeless)


@pytest.mark.parametrize("draft", ["", "pull more or less", "x" * 300])
def test_draft_and_correction_write_what_greedy_decoding_writes(exported, draft):
    recognizer = EmbeddedRecognizer("x", read_checkpoint(exported))
    with torch.inference_mode():
        for seed in range(2):
            states = states_of(recognizer.network, seed=seed)
            ids, _ = greedy(recognizer.network, states, MAX_ROUNDS - 1)
            text = written(recognizer, states, draft).text
            assert text.startswith(decode(ids).strip())


def test_commands_are_greedy_whatever_the_draft(base):
    drafts = ("", "hey robot", "zzzzzzzzzzzz zzzz", "the pull less or more of it")
    said = speak([Prompt(text, "flite", "slt", 1.0, 0.5) for text in texts.COMMANDS])
    with torch.inference_mode():
        for text, samples in zip(texts.COMMANDS, said, strict=True):
            amid_quiet = np.pad(samples.astype(np.float32) / 32768, RATE // 10)
            states = base._listen(amid_quiet).states
            ids, has_ended = greedy(base.network, states, MAX_ROUNDS - 1)
            assert has_ended
            assert decode(ids) == text
            for draft in drafts:
                assert written(base, states, draft).text == text, draft


def test_a_bad_draft_of_endless_talk_is_read_a_limited_number_of_times(exported, monkeypatch):
    recognizer = EmbeddedRecognizer("x", read_checkpoint(exported))
    read, logits = [], recognizer.network.logits

    def never_agrees(tokens, states, memory):
        read.append(tokens)
        found = logits(tokens, states, memory)
        found[..., BLANK] = -100.0  # no end
        found[:, :, encode("q")[0]] = 100.0
        return found

    monkeypatch.setattr(recognizer.network, "logits", never_agrees)
    with torch.inference_mode():
        states = states_of(recognizer.network, 2.0)
        heard = written(recognizer, states, "ab" * 20)
    assert len(read) == MAX_ROUNDS + 1  # once more to the end
    assert min(map(len, read)) < len("ab" * 20)
    assert heard.text == "q" * (MAX_ROUNDS - 1) + ("ab" * 20)[MAX_ROUNDS - 1 :]
    assert heard.avg_logprob < -10


def test_a_sound_is_read_once_for_text_and_scores_and_long_texts_in_parts(base, monkeypatch):
    read, logits = [], base.network.logits
    monkeypatch.setattr(
        base.network, "logits", lambda *given: read.append(given[0].tolist()) or logits(*given)
    )
    (said,) = speak([Prompt("please hold the camera still for me", "flite", "slt", 1.0, 0.5)])
    samples = frozen_samples(np.pad(said.astype(np.float32) / 32768, RATE // 10))
    text = base.transcribe(samples).text
    once = len(read)
    assert len(text) > 16
    assert base.transcribe(samples, lambda beginning: len(beginning) > 3).text[:3] == text[:3]
    assert len(read) == once
    base.score(samples, ["stop"])
    assert len(read) == once + 1  # all texts that are weighed, at once


def test_remembered_states_are_read_as_the_states_themselves(model):
    tokens = torch.tensor([[*PROMPT, *encode("pull more")]])
    with torch.inference_mode():
        states = states_of(model)
        memory, whole = model.remember(states), model.logits(tokens, states)
        for _ in range(2):
            torch.testing.assert_close(model.logits(tokens, states, memory), whole)


def test_spectrogram_is_whispers_own():
    samples = sound(0.8)
    theirs = whisper.log_mel_spectrogram(torch.from_numpy(samples))
    torch.testing.assert_close(log_mel(torch.from_numpy(samples)[None])[0], theirs)


def frames(path):
    """Log-probabilities that clearly say a path of CTC classes."""
    logits = torch.full((len(path), BLANK + 1), -6.0)
    logits[torch.arange(len(path)), torch.tensor(path)] = 6.0
    return logits.log_softmax(-1)


def test_alignment_finds_the_frames_of_each_letter():
    s, t, o, p = encode("stop")
    logprobs = frames([BLANK, s, s, BLANK, t, o, BLANK, BLANK, p, BLANK]).numpy()
    _, at = best_alignment(logprobs, np.array([s, t, o, p]))
    assert at[0] in (1, 2)
    assert at[1:].tolist() == [4, 5, 8]
    assert greedy_text(logprobs) == "stop"


def test_ctc_likelihoods_rank_what_was_said_first():
    path = [BLANK, *encode("less"[:3]), BLANK, encode("s")[0], BLANK]
    found = ctc_likelihoods(frames(path), ["less", "les", "", "more"])
    assert int(found.argmax()) == 0


def test_batched_decoder_likelihoods_equal_single_ones(model):
    with torch.inference_mode():
        states = states_of(model)
        words = ["stop", "pull more", "", "hey robot"]
        together = decoder_likelihoods(model, states, words)
        alone = [decoder_likelihoods(model, states, [word])[0] for word in words]
    torch.testing.assert_close(together, torch.stack(alone))


def test_no_speech_is_the_first_target_of_silence():
    tokens, targets = teacher_tensors([encode("ab"), []])
    assert tokens.shape == targets.shape
    assert targets[0, 0] != targets[1, 0]
    assert (targets[1, 2:] == IGNORED).all()


@pytest.mark.parametrize(
    ("size", "ids_of_letters"), [(51864, WHISPER_IDS), (51865, IDS_BY_SIZE[51865])]
)
def test_fine_tuning_starts_from_whispers_weights(tmp_path, size, ids_of_letters):
    theirs = whisper_file(tmp_path / "w.pt", n_vocab=size)
    start = start_from(str(tmp_path / "w.pt"))
    assert start.stages == (WRITING, *CONTINUED["mending"])
    ours = start.model.eval()
    states = states_of(ours)
    ids = [*PROMPT, *encode("stop")]
    wide = theirs.decoder(torch.tensor([[ids_of_letters[index] for index in ids]]), states)
    narrow = ours.logits(torch.tensor([ids]), states)
    used = list(ids_of_letters)
    torch.testing.assert_close(wide[..., used], narrow[..., : len(used)], atol=1e-4, rtol=1e-4)
    assert (ours.dims.n_audio_ctx, ours.dims.n_text_ctx) == (512, 192)


def test_fine_tuning_refuses_a_vocabulary_of_another_size(tmp_path):
    whisper_file(tmp_path / "w.pt", n_vocab=51866)
    with pytest.raises(ModelError, match="51866 tokens to start from, allowed: 51864, 51865"):
        start_from(str(tmp_path / "w.pt"))


def test_fine_tuning_keeps_the_encoder_and_a_short_decoder(tmp_path):
    theirs = whisper_file(tmp_path / "w.pt", n_audio_layer=3, n_text_layer=4)
    ours = start_from(str(tmp_path / "w.pt")).model
    assert (ours.dims.n_audio_layer, ours.dims.n_text_layer) == (3, 1)
    first = ours.whisper.decoder.blocks[0].state_dict()
    for name, weight in theirs.decoder.blocks[0].state_dict().items():
        torch.testing.assert_close(first[name], weight)


def test_a_balanced_run_hears_more_commands_than_a_mending_one(exported):
    (stage,), (mending,) = start_from(str(exported), "balanced").stages, CONTINUED["mending"]
    more, fewer = (s.weights["command"] / sum(s.weights.values()) for s in (stage, mending))
    assert more > fewer


def test_an_exported_checkpoint_is_the_same_each_time_and_continued_with_its_ctc_head(
    model, exported, tmp_path
):
    export(model, tmp_path / "model.pt")
    assert (tmp_path / "model.pt").read_bytes() == exported.read_bytes()
    start = start_from(str(exported))
    assert start.stages == CONTINUED["mending"]
    for name, weight in model.state_dict().items():
        torch.testing.assert_close(start.model.state_dict()[name], weight, atol=1e-3, rtol=1e-3)


def test_a_continued_run_has_one_lesson_with_word_times():
    for stages in CONTINUED.values():
        assert {stage_of(step, stages)[0] for step in (0, 1000, 50000)} == {0}
        assert stage_of(0, stages)[1].needs_word_times
    assert [stage_of(step)[0] for step in (0, 900, 1400)] == [0, 1, 2]
    assert [stage_of(step, (WRITING, *CONTINUED["mending"]))[0] for step in (0, 400)] == [0, 1]
