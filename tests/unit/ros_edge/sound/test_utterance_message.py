# SPDX-License-Identifier: BSD-3-Clause
"""The codes of `Utterance.msg` are those of the code, and each message carries one of them."""

from voice_assist.msg import Utterance
from voice_assist.ros.messages import utterance
from voice_assist.types import (
    Hypothesis,
    Match,
    Mode,
    NoMatch,
    Rejection,
    RejectionReason,
    UtteranceDecision,
)


def message_of(outcome):
    decision = UtteranceDecision(
        Hypothesis("tense", 0.0, 0.0), outcome, 0.4, Mode.ACTIVE, 1.0, 2.0, 2.1, False
    )
    return utterance(decision, 2.2)


def test_the_message_lists_every_reason_of_the_code_and_no_other():
    listed = {name: value for name, value in vars(Utterance).items() if name.isupper()}
    assert listed == {reason.name: reason.value for reason in RejectionReason}


def test_a_refused_utterance_carries_code_and_words():
    rejection = Rejection(RejectionReason.UNSURE, "confidence 0.40, allowed: at least 0.80")
    message = message_of(NoMatch(rejection, "tense", {"tense": 0.0}))
    assert (message.command, message.nearest_command) == ("", "tense")
    assert (message.reason_code, message.reason) == ("unsure", rejection.words)


def test_a_command_carries_no_code():
    message = message_of(Match("tense", {"tense": 0.0}))
    assert (message.command, message.nearest_command) == ("tense", "tense")
    assert (message.reason_code, message.reason) == ("", "")


def test_speech_from_before_a_simulated_clock_began_is_stamped_zero():
    decision = UtteranceDecision(
        Hypothesis("stop", 0.0, 0.0), Match("stop", {}), 1.0, Mode.ACTIVE, -0.4, 0.01, 0.02, True
    )
    message = utterance(decision, 0.02)
    assert (message.speech_start.to_sec(), message.speech_end.to_sec()) == (0.0, 0.01)
