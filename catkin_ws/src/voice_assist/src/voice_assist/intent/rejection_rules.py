# SPDX-License-Identifier: BSD-3-Clause
"""What keeps a command that was heard from being taken; nothing here can refuse a halt."""

from __future__ import annotations

from typing import TYPE_CHECKING

from voice_assist.audio.corruption import damage
from voice_assist.audio.pitch import glide
from voice_assist.audio.robot_speech import Talkback
from voice_assist.config import VoiceConfig
from voice_assist.config.commands import CommandConfig
from voice_assist.intent.early_decision import too_unsure
from voice_assist.types import Hypothesis, Rejection, RejectionReason, Samples
from voice_assist.vad.segmenter import Growth

if TYPE_CHECKING:
    from voice_assist.speaker.gate import Gate


class Objections:
    """Asked about each command that the words and the scores agree on."""

    def __init__(self, config: VoiceConfig, talkback: Talkback, gate: Gate | None) -> None:
        """Join them.

        Args:
            config: Of all stages.
            talkback: When the robot itself speaks.
            gate: Tells whose voice may not move the robot; None: any voice may.
        """
        self._config, self._talkback, self._gate = config.recognizer, talkback, gate

    def __call__(
        self, command: CommandConfig, heard: Hypothesis, sound: Samples, growth: Growth
    ) -> Rejection | None:
        """Why a command is not taken; None: it is.

        Args:
            command: That was heard.
            heard: As what.
            sound: That it was heard in, shape (n,).
            growth: The utterance that it was said in.
        """
        wakes = command.mode_after == "active"
        if (command.is_motion or wakes) and self._talkback.is_in(growth.utterance.speech_start):
            words = "the robot itself was speaking; say it again"
            return Rejection(RejectionReason.ROBOT_SPEAKING, words)
        return self._of_motion(heard, sound, growth.clearness) if command.is_motion else None

    def _of_motion(self, heard: Hypothesis, sound: Samples, clearness: float) -> Rejection | None:
        if clearness < self._config.motion_speech:
            return too_faint(clearness, self._config.motion_speech)
        least = self._config.motion_confidence
        if heard.confidence < least:
            return too_unsure(heard.confidence, least, " of the transcript")
        if words := damage(sound):
            return Rejection(RejectionReason.DAMAGED_SOUND, words)
        moved, least = glide(sound), self._config.motion_pitch_variation
        if moved < least:
            words = f"a tone, no voice: its pitch moves by {moved:.2f} cent, a voice's by {least:g}"
            return Rejection(RejectionReason.TONE, words)
        return self._gate(sound) if self._gate else None


def too_faint(clearness: float, least: float) -> Rejection:
    """Why a motion is refused in a sound that may be no voice."""
    told = f"the speech detector gave {clearness:.2f} at most, allowed: at least {least:.2f}"
    return Rejection(RejectionReason.UNSURE, f"too faint to be surely speech: {told}")
