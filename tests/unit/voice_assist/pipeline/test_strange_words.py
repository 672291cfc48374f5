# SPDX-License-Identifier: BSD-3-Clause
"""A strange word that is written like a motion moves nothing; nothing else is ever verified."""

import pytest

from tests.unit.voice_assist.support.fake_pipeline import commands, hear, refusals
from tests.unit.voice_assist.support.fake_speech import FakeRecognizer
from voice_assist.config import load_voice_config
from voice_assist.types import Mode, RejectionReason

MOTIONS = ("tense", "release", "pull more", "pull less")
LEAST = load_voice_config().recognizer.motion_verification
TOO_LOW = load_voice_config().recognizer.ask.min_verification - 0.1  # even to be asked for


class Asked(FakeRecognizer):
    """Notes what it is asked to verify, and is sure of nothing."""

    def __init__(self, confidence=0.9):
        super().__init__(confidence=confidence)
        self.asked = []

    def verify(self, samples, phrase):
        self.asked.append(phrase)
        return -1000.0


@pytest.mark.parametrize("command", MOTIONS)
def test_a_motion_of_too_low_odds_is_refused_with_them_and_what_is_allowed(command):
    events = hear(command, recognizer=FakeRecognizer(odds={command: TOO_LOW}))
    assert commands(events) == []
    (refusal,) = refusals(events)
    assert refusal.nearest_command == command
    assert refusal.rejection.reason is RejectionReason.SOUNDS_LIKE_ANOTHER
    found = f"it sounds like another word that is written {command!r}: {TOO_LOW:.1f} nat"
    assert refusal.rejection.words == f"{found}, allowed: at least {LEAST:g}"
    # from the least odds on it is taken
    assert commands(hear(command, recognizer=FakeRecognizer(odds={command: LEAST}))) == [command]


@pytest.mark.parametrize("mode", [Mode.ACTIVE, Mode.STANDBY])
@pytest.mark.parametrize("command", ["stop", "hey robot"])
def test_a_stop_and_what_moves_nothing_are_never_verified(command, mode):
    recognizer = Asked()
    assert commands(hear(command, mode, recognizer)) == [command]
    assert recognizer.asked == []


def test_without_a_second_opinion_nothing_is_verified():
    recognizer = Asked(confidence=0.95)
    heard = hear("release", recognizer=recognizer, recognizer__second_opinion=False)
    assert commands(heard) == ["release"] and recognizer.asked == []
