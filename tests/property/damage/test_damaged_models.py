# SPDX-License-Identifier: BSD-3-Clause
"""Model files that are damaged or hostile: refused in words, and nothing in them runs."""

import os
import pickle
import random
import zipfile
from functools import partial

import pytest
import torch
from whisper.model import ModelDimensions, Whisper

from voice_assist.errors import ModelError
from voice_assist.recognizer import safe_weights
from voice_assist.recognizer.checkpoint import EMBEDDED_PATH, read_checkpoint
from voice_assist.recognizer.vocabulary import BLANK
from voice_assist.recognizer.whisper_shapes import whisper_shapes
from voice_assist.spotter.head import PATH, Head, read_head
from voice_assist.spotter.overlap import read_overlap, untrained

DIMS = {
    **{"n_mels": 80, "n_audio_ctx": 512, "n_audio_state": 4, "n_audio_head": 2, "n_audio_layer": 2},
    **{"n_vocab": 51864, "n_text_ctx": 64, "n_text_state": 4, "n_text_head": 2, "n_text_layer": 1},
}


class Intruder:
    """Would make a file if it were unpickled."""

    def __init__(self, trace):
        self.trace = trace

    def __reduce__(self):
        return (os.system, (f"touch '{self.trace}'",))


def checkpoint():
    shapes = whisper_shapes(ModelDimensions(**DIMS))
    return {
        "dims": dict(DIMS),
        "model_state_dict": {name: torch.ones(shape) for name, shape in shapes.items()},
        "ctc_state_dict": {"weight": torch.ones(BLANK + 1, 4), "bias": torch.ones(BLANK + 1)},
    }


def head():
    return Head().state_dict()


@pytest.fixture(scope="module")
def encoder(tmp_path_factory):
    """The file of a recogniser that a spotter over talk is made for."""
    return saved(tmp_path_factory.mktemp("encoder") / "encoder.pt", checkpoint())


@pytest.fixture(params=["checkpoint", "head", "overlap"])
def reader(request, encoder):
    """What reads a kind of file, and what makes the content of a right one."""
    made_for = read_checkpoint(encoder)

    def overlap():
        state = dict(untrained(made_for).own_state())
        return {"encoder_sha256": made_for.sha256, "state": state}

    return {
        "checkpoint": (read_checkpoint, checkpoint),
        "head": (read_head, head),
        "overlap": (partial(read_overlap, encoder=encoder), overlap),
    }[request.param]


def refusal(read, path):
    """The error in words; empty: the file is accepted. Any other error fails the test."""
    try:
        read(path)
    except ModelError as error:
        return str(error)
    return ""


def saved(path, content):
    torch.save(content, path)
    return path


def test_the_shapes_are_those_of_the_library():
    dims = ModelDimensions(**DIMS)
    assert {name: tuple(w.shape) for name, w in Whisper(dims).state_dict().items()} == (
        whisper_shapes(dims)
    )


def test_what_is_whole_is_read(tmp_path):
    assert read_checkpoint(saved(tmp_path / "a.pt", checkpoint())).ctc is not None
    plain = {key: value for key, value in checkpoint().items() if key != "ctc_state_dict"}
    assert read_checkpoint(saved(tmp_path / "b.pt", plain)).ctc is None
    assert len(read_checkpoint(EMBEDDED_PATH).sha256) == 64
    assert len(read_head(PATH)[1]) == 64


def test_any_bytes_cuts_and_changes_are_refused_or_change_nothing(reader, tmp_path):
    read, make = reader
    whole = saved(tmp_path / "whole.pt", make()).read_bytes()
    order, file, accepted = random.Random(5), tmp_path / "damaged.pt", 0
    for index in range(60):
        cut = order.randrange(len(whole))
        damaged = bytearray(whole)
        damaged[cut] ^= 1 << order.randrange(8)
        data = (order.randbytes(cut % 5000), whole[:cut], damaged, whole[cut:])[index % 4]
        file.write_bytes(data)
        words = refusal(read, file)
        assert "damaged.pt" in words or not words
        if not words:  # a byte between the records, which nobody reads
            accepted += 1
            assert index % 4 == 2
            assert repr(torch.load(file, weights_only=True)) == repr(
                torch.load(tmp_path / "whole.pt", weights_only=True)
            )
    assert accepted < 10


def test_code_in_a_file_never_runs_and_the_error_says_what_was_expected(reader, tmp_path):
    read, make = reader
    trace, content = tmp_path / "ran", make()
    content[next(iter(content))] = Intruder(trace)
    hidden = make()
    hidden["more"] = {"deep": [Intruder(trace)]}
    files = {"zip.pt": content, "deep.pt": hidden, "alone.pt": Intruder(trace)}
    for name, data in files.items():
        words = refusal(read, saved(tmp_path / name, data))
        assert name in words and "no plain weights" in words and "plain tensors" in words
    (tmp_path / "pickle.pt").write_bytes(pickle.dumps(content))
    torch.save(content, tmp_path / "old.pt", _use_new_zipfile_serialization=False)
    for name in ("pickle.pt", "old.pt"):
        words = refusal(read, tmp_path / name)
        assert name in words and "no zip archive, allowed: plain tensors" in words
    assert not trace.exists()
    pickle.loads(pickle.dumps(Intruder(trace)))
    assert trace.exists()  # it would have run


def broken_weights(name, tensor):
    """What may stand in place of one tensor."""
    for number in (float("nan"), float("inf"), -float("inf")):
        bad = tensor.clone()
        bad.view(-1)[-1] = number
        yield bad, "holds 1 NaN or infinite, allowed: finite"
    yield tensor.new_ones((*tensor.shape, 2)), "has the shape"
    yield tensor[:-1].clone(), "has the shape"
    yield tensor.to(torch.int32), "is of torch.int32, allowed: one of (torch.float64, torch.float32"
    yield tensor.to(torch.float8_e4m3fn), "is of torch.float8_e4m3fn"
    yield tensor.to(torch.float8_e5m2), "is of torch.float8_e5m2"
    yield tensor.to(torch.complex64), "is of torch.complex64"
    yield tensor.to_sparse(), "allowed: a dense tensor"
    yield [1.0], "is list, allowed: a dense tensor"
    yield None, "is NoneType, allowed: a dense tensor"


def test_weights_that_are_no_numbers_or_do_not_fit_are_refused_by_name(reader, tmp_path):
    read, make = reader
    content = make()
    parts = [part for key, part in content.items() if isinstance(part, dict) and key != "dims"]
    for part in parts or [content]:
        name = list(part)[-1]
        whole = part[name]
        for bad, words in broken_weights(name, whole):
            part[name] = bad
            found = refusal(read, saved(tmp_path / "bad.pt", content))
            assert "bad.pt" in found and name in found and words in found, (words, found)
        del part[name]
        assert f"1 missing, such as {name}" in refusal(read, saved(tmp_path / "bad.pt", content))
        part.update({name: whole, "more": whole})
        assert "1 unknown, such as more" in refusal(read, saved(tmp_path / "bad.pt", content))
        del part["more"]


def test_a_spread_that_is_not_above_0_is_refused(tmp_path):
    content = head()
    content["spread"][3] = 0.0
    assert "spread has 0, allowed: above 0" in refusal(read_head, saved(tmp_path / "h.pt", content))


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"n_audio_layer": 10**9}, "n_audio_layer is 1000000000, allowed: a whole number from 1"),
        ({"n_audio_state": 10**7}, "n_audio_state is 10000000, allowed: a whole number from 4"),
        ({"n_text_ctx": 2**40}, "n_text_ctx is 1099511627776, allowed"),
        ({"n_audio_state": 4096, "n_text_state": 4096}, "has the shape"),
        ({"n_audio_ctx": 100}, "at least 500, which 10 s of sound need"),
        ({"n_vocab": 0}, "n_vocab is 0, allowed: a whole number from 51864"),
        ({"n_mels": 100}, "n_mels is 100, allowed: 80 or 128"),
        ({"n_mels": -80}, "n_mels is -80, allowed"),
        ({"n_text_layer": 2.0}, "n_text_layer is 2.0, allowed: a whole number"),
        ({"n_text_layer": True}, "n_text_layer is True, allowed: a whole number"),
        ({"n_text_layer": "1"}, "n_text_layer is '1', allowed: a whole number"),
        ({"n_audio_head": 3}, "n_audio_state is 4, allowed: an even multiple of its 3 heads"),
        ({"n_audio_state": 5, "n_audio_head": 1}, "an even multiple of its 1 heads"),
        ({"n_text_state": 8}, "n_text_state is 8, allowed: as n_audio_state, 4"),
        ({"more": 1}, "allowed: n_mels, n_audio_ctx"),
    ],
)
def test_sizes_that_no_model_has_are_refused_before_anything_is_built(changes, words, tmp_path):
    content = checkpoint()
    content["dims"] |= changes
    found = refusal(read_checkpoint, saved(tmp_path / "dims.pt", content))
    assert "dims.pt" in found and words in found, found


@pytest.mark.parametrize("content", [[], {}, 3, {"dims": DIMS}, {**DIMS}, torch.ones(3)])
def test_what_is_no_checkpoint_is_refused_with_the_keys_of_one(content, tmp_path):
    found = refusal(read_checkpoint, saved(tmp_path / "x.pt", content))
    assert "allowed: 'dims' and 'model_state_dict'" in found


def test_a_misspelt_part_does_not_make_another_kind_of_model(tmp_path):
    """Without its CTC head this project's model would be taken for one of OpenAI's."""
    content = checkpoint()
    content["ctc_state"] = content.pop("ctc_state_dict")
    found = refusal(read_checkpoint, saved(tmp_path / "x.pt", content))
    assert "dims, model_state_dict, ctc_state, allowed" in found


def test_dims_that_are_missing_are_named(tmp_path):
    content = checkpoint()
    del content["dims"]["n_mels"]
    assert "allowed: n_mels" in refusal(read_checkpoint, saved(tmp_path / "x.pt", content))
    content["dims"] = None
    assert "dims has NoneType" in refusal(read_checkpoint, saved(tmp_path / "x.pt", content))


def test_an_archive_that_unpacks_to_more_than_memory_is_refused_unopened(
    reader, tmp_path, monkeypatch
):
    read, _ = reader
    path = tmp_path / "bomb.pt"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("archive/data.pkl", bytes(1_000_001))
    assert path.stat().st_size < 2000
    monkeypatch.setattr(safe_weights, "LARGEST", 1_000_000)
    words = refusal(read, path)
    assert "bomb.pt unpacks to 1000001 bytes, allowed: at most 1000000" in words


def test_a_file_that_is_not_there_or_is_a_folder_is_named(reader, tmp_path):
    read, _ = reader
    for path in (tmp_path / "none.pt", tmp_path):
        assert str(path) in refusal(read, path)
