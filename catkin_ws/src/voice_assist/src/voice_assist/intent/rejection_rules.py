# SPDX-License-Identifier: BSD-3-Clause
"""What keeps a recognised command from being taken; nothing here can refuse a halt."""

from __future__ import annotations

from typing import TYPE_CHECKING

from voice_assist.audio.corruption import find_corruption
from voice_assist.audio.pitch import pitch_variation
from voice_assist.audio.robot_speech import RobotSpeech
from voice_assist.audio.talk_gate import TalkGate
from voice_assist.config import VoiceConfig
from voice_assist.config.commands import CommandConfig
from voice_assist.config.voice import AskConfig
from voice_assist.intent.early_decision import too_unsure
from voice_assist.types import Hypothesis, Rejection, RejectionReason, Samples
from voice_assist.vad.segmenter import PartialUtterance

if TYPE_CHECKING:
    from voice_assist.speaker.gate import Gate


class RejectionRules:
    """Applied to each command that the words and the scores agree on, in this order."""

    def __init__(
        self,
        config: VoiceConfig,
        robot_speech: RobotSpeech,
        talk_gate: TalkGate,
        gate: Gate | None,
    ) -> None:
        """Join them.

        Args:
            config: Of all stages.
            robot_speech: When the robot itself speaks.
            talk_gate: Whether voice counted, as a pedal says.
            gate: Refuses motions in other voices; None: any voice may move the robot.
        """
        self._config, self._robot_speech, self._gate = config.recognizer, robot_speech, gate
        self._talk_gate = talk_gate

    def __call__(
        self,
        command: CommandConfig,
        transcript: Hypothesis,
        sound: Samples,
        partial: PartialUtterance,
    ) -> Rejection | None:
        """Why a command is not taken; None: it is.

        Args:
            command: That was recognised.
            transcript: That it was recognised by.
            sound: That it was recognised in, shape (n,).
            partial: The utterance that it was said in.
        """
        said = partial.utterance.speech_start, partial.utterance.speech_end
        if not self._talk_gate.was_open(*said):
            words = "voice does not count now, as the talk pedal stands"
            return Rejection(RejectionReason.TALK_GATE, words)
        wakes = command.mode_after == "active"
        if (command.is_motion or wakes) and self._robot_speech.is_in(
            partial.utterance.speech_start
        ):
            words = "the robot itself was speaking; say it again"
            return Rejection(RejectionReason.ROBOT_SPEAKING, words)
        return self._of_motion(transcript, sound, partial.clearness) if command.is_motion else None

    def _of_motion(
        self, transcript: Hypothesis, sound: Samples, clearness: float
    ) -> Rejection | None:
        if clearness < self._config.motion_speech:
            return too_faint(clearness, self._config.motion_speech)
        minimum = self._config.motion_confidence
        if transcript.confidence < minimum:
            return too_unsure(transcript.confidence, minimum, " of the transcript")
        if words := find_corruption(sound):
            return Rejection(RejectionReason.DAMAGED_SOUND, words)
        moved, minimum = pitch_variation(sound), self._config.motion_pitch_variation
        if moved < minimum:
            moves = f"its pitch moves by {moved:.2f} cent, a voice's by {minimum:g}"
            return Rejection(RejectionReason.TONE, f"a tone, no voice: {moves}")
        return self._gate(sound) if self._gate else None


def to_be_confirmed(ask: AskConfig, what: str, why: str) -> Rejection:
    """What asks for a motion instead of doing it."""
    words = f'{what}; say "{ask.answer}" within {ask.answer_within:g} s: {why}'
    return Rejection(RejectionReason.NEARLY_SURE, words)


def to_be_said_again(ask: AskConfig) -> Rejection:
    """What asks for every motion, where none is taken at once."""
    words = f"said once; say it again within {ask.answer_within:g} s"
    return Rejection(RejectionReason.NEARLY_SURE, words)


def another_word(command: str, odds: float, minimum: float) -> Rejection:
    """Why a motion is refused whose sound may be a strange word's; log-odds in nat."""
    words = f"it sounds like another word that is written {command!r}: {odds:.1f} nat"
    return Rejection(RejectionReason.SOUNDS_LIKE_ANOTHER, f"{words}, allowed: at least {minimum:g}")


def too_faint(clearness: float, minimum: float) -> Rejection:
    """Why a motion is refused in a sound that may be no voice."""
    words = f"the speech detector gave {clearness:.2f} at most, allowed: at least {minimum:.2f}"
    return Rejection(RejectionReason.UNSURE, f"too faint to be surely speech: {words}")
