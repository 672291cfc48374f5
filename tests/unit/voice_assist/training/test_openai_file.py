# SPDX-License-Identifier: BSD-3-Clause
"""A file is OpenAI's only if the whisper library knows its digest."""

import hashlib
import re

import pytest
import whisper

from voice_assist.errors import ModelError
from voice_assist.training.fit import openai_file


def test_a_known_digest_is_named_and_a_changed_file_refused(tmp_path, monkeypatch):
    file = tmp_path / "any.pt"
    file.write_bytes(b"weights")
    digest = hashlib.sha256(b"weights").hexdigest()
    monkeypatch.setattr(whisper, "_MODELS", {"huge.en": f"there/{digest}/huge.en.pt"})
    assert openai_file.openai_name(file) == "huge.en"
    file.write_bytes(b"weights, changed")
    with pytest.raises(ModelError, match=re.escape(f"{file} has the SHA-256 ")):
        openai_file.openai_name(file)


def test_a_missing_file_is_named_in_words(tmp_path, refused):
    assert "no.pt: no such file" in refused(openai_file, tmp_path / "no.pt")
