# SPDX-License-Identifier: BSD-3-Clause
"""Models of OpenAI's sizes, with small random weights: what is written, scored and converted."""

import struct
from types import SimpleNamespace

import numpy as np
import pytest
import torch
from whisper.model import ModelDimensions, Whisper

from voice_assist.errors import ModelError
from voice_assist.recognizer.ctranslate2 import convert
from voice_assist.recognizer.token_tree import TokenTree, likelihoods
from voice_assist.recognizer.whisper import OpenAIRecognizer, load_recognizer, once
from voice_assist.types import RATE, Hypothesis

DIMS = ModelDimensions(80, 600, 64, 1, 2, 51864, 64, 64, 1, 2)
PHRASES = ("stop", "pull more", "pull less")
CT2_TYPES = ("float32", "int8", "int16", "int32", "float16")


@pytest.fixture(scope="module")
def model():
    torch.manual_seed(0)
    made = Whisper(DIMS).eval()
    for name in ("encoder", "decoder"):
        torch.nn.init.normal_(made.get_submodule(name).positional_embedding, std=0.1)
    return made


@pytest.fixture(scope="module")
def checkpoint(model):
    return SimpleNamespace(dims=DIMS, state=model.state_dict(), sha256="none")


@pytest.fixture(scope="module")
def recognizer(checkpoint):
    return OpenAIRecognizer("small", checkpoint, max_tokens=8, dtype=torch.float32)


def test_a_model_with_english_words_alone_refuses_another_language(checkpoint):
    with pytest.raises(ModelError, match=r"hears English only, not 'de'.*make languages"):
        OpenAIRecognizer("small", checkpoint, language="de")


def sound(seed=0):
    samples = np.random.default_rng(seed).standard_normal(RATE).astype(np.float32) * 0.1
    samples.flags.writeable = False
    return samples


@pytest.mark.parametrize(
    ("text", "kept"),
    [
        ("Stop Stop Stop", "Stop"),
        ("Pull more. Pull more", "Pull more."),
        ("stop! Stop", "stop!"),
        ("pull more", "pull more"),
        ("more or less more", "more or less more"),
        ("the past tense", "the past tense"),
        ("少し上げて少し上げて少し上げて少", "少し上げて"),
        ("そろそろ終わります", "そろそろ終わります"),
        ("", ""),
    ],
)
def test_a_text_that_begins_anew_is_taken_once(text, kept):
    assert once(text) == kept


def test_each_beginning_is_one_node_that_sees_only_its_ancestors():
    tree = TokenTree()
    paths = [tree.add(line) for line in ((7, 1, 2), (7, 1, 3), (7, 2))]
    assert tree.tokens == [7, 1, 2, 3, 2]
    assert paths == [[0, 1, 2], [0, 1, 3], [0, 4]]
    assert tree.depths() == [0, 1, 2, 2, 1]
    assert (tree.mask() == 0).tolist() == [
        [True, False, False, False, False],
        [True, True, False, False, False],
        [True, True, True, False, False],
        [True, True, False, True, False],
        [True, False, False, False, True],
    ]


def test_likelihoods_are_those_of_one_text_at_a_time(model):
    states, prompt, end = torch.randn(1, 40, 64), [1, 2, 3], 50256
    lines = [[5], [5, 6], [5, 7, 8], [], [9, 6]]
    with torch.inference_mode():
        found = likelihoods(model.decoder, states, prompt, lines, end)
        for line, one in zip(lines, found, strict=True):
            tokens = [*prompt, *line]
            logprobs = model.decoder(torch.tensor([tokens]), states)[0].log_softmax(-1)
            wanted = [*line, end]
            rows = range(len(prompt) - 1, len(tokens))
            alone = sum(float(logprobs[row, t]) for row, t in zip(rows, wanted, strict=True))
            assert one == pytest.approx(alone, abs=1e-3)


def test_a_sound_is_encoded_once_for_text_and_scores(recognizer, monkeypatch):
    calls = []
    encoder = recognizer.model.encoder
    call = encoder.conv1.forward
    monkeypatch.setattr(encoder.conv1, "forward", lambda x: calls.append(None) or call(x))
    heard = sound(1)
    recognizer.transcribe(heard)
    first = recognizer.score(heard, PHRASES)
    assert len(calls) == 1
    assert recognizer.score(heard.copy(), PHRASES) == pytest.approx(first)
    assert len(calls) == 2  # it may have been changed


def test_a_text_of_odd_letters_is_weighed_though_it_fills_the_context(recognizer):
    heard = sound(3)
    odd = "\ufffd" * 200  # three tokens each
    recognizer._listen(heard).text = Hypothesis(odd, -1.0, 0.0)
    assert all(np.isfinite(score) for score in recognizer.score(heard, PHRASES).values())


def test_a_hopeless_text_ends_and_its_whole_is_still_weighed(recognizer):
    heard, asked = sound(2), []
    recognizer.transcribe(heard, lambda text: asked.append(text) or True)
    assert len(asked) == 1
    fresh = recognizer.score(sound(2).copy(), PHRASES)
    assert recognizer.score(heard, PHRASES) == pytest.approx(fresh)


def test_a_model_of_ctranslate2_hears_what_its_original_hears(model, tmp_path):
    whole = ct2_file(model)
    parts = [tmp_path / "one", tmp_path / "two"]
    parts[0].write_bytes(whole[:100_000])
    parts[1].write_bytes(whole[100_000:])
    convert(parts, tmp_path / "model.pt")
    read = load_recognizer(str(tmp_path / "model.pt")).model.state_dict()
    assert read.keys() == model.state_dict().keys()
    for name, weight in model.state_dict().items():
        assert torch.allclose(read[name].float(), weight, atol=0.02), name


@pytest.mark.parametrize(
    ("damage", "words"),
    [
        (lambda b: b[:-5], "ends after"),
        (lambda b: b[:50], "ends after|unpack"),
        (lambda b: b"\x07" + b[1:], "version 7"),
        (lambda b: b.replace(b"encoder/conv1", b"encoder/conv9"), "conv1"),
        (lambda b: b"", "unpack|ends after"),
    ],
)
def test_a_damaged_model_is_named_and_nothing_is_written(model, tmp_path, damage, words):
    file = tmp_path / "model.bin"
    file.write_bytes(damage(ct2_file(model)))
    with pytest.raises(ModelError, match=words) as error:
        convert([file], tmp_path / "model.pt")
    assert str(file) in str(error.value)
    assert not (tmp_path / "model.pt").exists()


@pytest.mark.parametrize(
    "name", ["encoder/layer_0/ffn/linear_0/weight", "decoder/embeddings/weight"]
)
@pytest.mark.parametrize("kind", ["int8", "int16", "int32"])
def test_a_quantised_model_is_refused_by_the_name_of_the_tensor(model, tmp_path, name, kind):
    file = tmp_path / "model.bin"
    file.write_bytes(ct2_file(model, {name: kind}))
    with pytest.raises(ModelError, match=f"{name} is of type {kind}, allowed: float32 or float16"):
        convert([file], tmp_path / "model.pt")
    assert not (tmp_path / "model.pt").exists()


def test_a_model_in_single_precision_is_converted_and_a_missing_part_is_named(model, tmp_path):
    (tmp_path / "model.bin").write_bytes(ct2_file(model, {"encoder/conv1/weight": "float32"}))
    convert([tmp_path / "model.bin"], tmp_path / "model.pt")
    assert (tmp_path / "model.pt").exists()
    with pytest.raises(ModelError, match=r"none\.bin: No such file"):
        convert([tmp_path / "none.bin"], tmp_path / "model.pt")


def ct2_file(model, types=None):
    """The model in CTranslate2's format, as its converter stacks it; types by names of arrays."""
    state = {name: weight.numpy().astype("<f2") for name, weight in model.state_dict().items()}
    arrays = {
        "encoder/position_encodings/encodings": state["encoder.positional_embedding"],
        "decoder/position_encodings/encodings": state["decoder.positional_embedding"],
        "decoder/embeddings/weight": state["decoder.token_embedding.weight"],
    }

    def linear(theirs, *ours):
        arrays[f"{theirs}/weight"] = np.concatenate([state[f"{o}.weight"] for o in ours])
        none = np.zeros(64, "<f2")  # keys
        arrays[f"{theirs}/bias"] = np.concatenate([state.get(f"{o}.bias", none) for o in ours])

    def norm(theirs, ours):
        arrays[f"{theirs}/gamma"] = state[f"{ours}.weight"]
        arrays[f"{theirs}/beta"] = state[f"{ours}.bias"]

    for conv in ("conv1", "conv2"):
        linear(f"encoder/{conv}", f"encoder.{conv}")
    norm("encoder/layer_norm", "encoder.ln_post")
    norm("decoder/layer_norm", "decoder.ln")
    for part in ("encoder", "decoder"):
        for i in range(2):
            theirs, ours = f"{part}/layer_{i}", f"{part}.blocks.{i}"
            linear(f"{theirs}/ffn/linear_0", f"{ours}.mlp.0")
            linear(f"{theirs}/ffn/linear_1", f"{ours}.mlp.2")
            norm(f"{theirs}/ffn/layer_norm", f"{ours}.mlp_ln")
            norm(f"{theirs}/self_attention/layer_norm", f"{ours}.attn_ln")
            own = f"{ours}.attn"
            linear(
                f"{theirs}/self_attention/linear_0", f"{own}.query", f"{own}.key", f"{own}.value"
            )
            linear(f"{theirs}/self_attention/linear_1", f"{own}.out")
            if part == "decoder":
                own = f"{ours}.cross_attn"
                norm(f"{theirs}/attention/layer_norm", f"{ours}.cross_attn_ln")
                linear(f"{theirs}/attention/linear_0", f"{own}.query")
                linear(f"{theirs}/attention/linear_1", f"{own}.key", f"{own}.value")
                linear(f"{theirs}/attention/linear_2", f"{own}.out")
    content = struct.pack("<I", 6) + _text("WhisperSpec") + struct.pack("<II", 3, len(arrays))
    for name, values in arrays.items():
        values = values.astype((types or {}).get(name, "float16"))
        content += _text(name) + struct.pack(f"<B{values.ndim}I", values.ndim, *values.shape)
        kind = CT2_TYPES.index(values.dtype.name)
        content += struct.pack("<BI", kind, values.nbytes) + values.tobytes()
    return content + struct.pack("<I", 0)


def _text(words):
    return struct.pack("<H", len(words) + 1) + words.encode() + b"\0"
