# SPDX-License-Identifier: BSD-3-Clause
"""A recogniser of the language of tones that an enrolment takes."""

from tests.unit.voice_assist.support.fake_speech import FakeRecognizer
from voice_assist.recognizer.embedded import EmbeddedRecognizer


class Adaptable(FakeRecognizer, EmbeddedRecognizer):
    """Could be adapted; no test does."""

    model_hash = "ab" * 32
