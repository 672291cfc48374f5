# SPDX-License-Identifier: BSD-3-Clause
"""Decodes an utterance again and again while it grows: when, and to which transcript."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from voice_assist.config import EarlyConfig
from voice_assist.side_inputs import Observer, SideInput, SideInputKind, ignore
from voice_assist.types import (
    RATE,
    Frame,
    Hypothesis,
    IsHopeless,
    Samples,
    frozen_samples,
    never_hopeless,
)
from voice_assist.vad.segmenter import PartialUtterance, last

if TYPE_CHECKING:
    from voice_assist.recognizer.recognizer import Recognizer

_SLACK = 1e-6  # [s] so that sums of frame lengths reach their limits
_COSTS = 3  # passes; one that the machine held up makes no model slow
_BUSY = 0.33  # share of the time that passes may take of a model slower than `partial_interval`


class PartialDecoder:
    """Transcripts and scores of one utterance.

    Decoder passes are `partial_interval` apart while there is speech. One more comes after `settle`
    of quiet. It stands until there is speech again, so that the end of the `pause` finds nothing
    left to compute. Of a long utterance only the last `window` is decoded, which bounds each pass:
    a command is short. While the robot itself speaks or moves, the very last part is decoded alone
    too, since one word may stand by itself in it. A model that is slower than `partial_interval`
    is asked less often, but not while the robot moves.
    """

    def __init__(
        self,
        recognizer: Recognizer,
        config: EarlyConfig,
        clock: Callable[[], float],
        observer: Observer = ignore,
        is_hopeless: IsHopeless = never_hopeless,
    ) -> None:
        """Start with a new utterance.

        Args:
            recognizer: Makes text of sound.
            config: When to decode.
            clock: The one that stamps the frames [s].
            observer: Gets each pass that is skipped, since the sound comes too late or the model
                is slow.
            is_hopeless: Of the beginning of a text: no continuation of it is a command.
        """
        self._recognizer, self._config, self._clock = recognizer, config, clock
        self._observer, self._is_hopeless = observer, is_hopeless
        self._costs = deque([0.0] * _COSTS, _COSTS)  # [s] of the newest passes
        self.reset()

    def reset(self) -> None:
        """Start with a new utterance."""
        self.transcript: Hypothesis | None = None  # newest
        self.part: Hypothesis | None = None  # of the last part alone, at the same moment
        self.is_window = False  # it is only of the utterance's last part
        self.worded_at = float("-inf")  # [s] stream time of the newest pass that found a word
        self._decoded_at: float | None = None  # [s] stream time of the newest pass
        self._has_news = False  # there was speech since the newest pass
        self._pause_noted = False  # the pause was reached since there was speech
        self._ignored_until = float("-inf")  # [s] speech that ends before is not decoded
        self._sound: Samples | None = None  # of the newest pass
        self._scores: dict[str, float] = {}
        self._verified: dict[str, float] = {}

    def restart(self, partial: PartialUtterance) -> None:
        """Go on with the rest of the utterance only."""
        worded_at = self.worded_at
        self.reset()
        self.worded_at = worded_at
        self._ignored_until = partial.utterance.speech_end + self._config.min_rest

    def __call__(
        self, partial: PartialUtterance, frame: Frame, time: float, part: float = 0.0
    ) -> bool:
        """Follow the utterance by a frame.

        Args:
            partial: The utterance with that frame.
            frame: The frame.
            time: Stream time of its end [s].
            part: Length of the last part that is decoded by itself too [s]; 0: none is.

        Returns:
            Whether a decision may have become possible.
        """
        if partial.quiet == 0.0:
            self._has_news, self._pause_noted = True, False
        if self._decoded_at is None:
            self._decoded_at = time
        is_pause = self.has_paused(partial)
        is_turn = partial.utterance.is_complete or (is_pause and not self._pause_noted)
        self._pause_noted |= is_pause
        is_new = self._is_due(partial, frame, time, is_turn)
        if is_new:
            self._decode(partial, time, part, frame.is_moving)
        return self.transcript is not None and (is_new or is_turn)

    def is_settled(self, partial: PartialUtterance) -> bool:
        """Whether the newest transcript stands until there is speech again."""
        return partial.quiet >= self._config.settle - _SLACK

    def has_paused(self, partial: PartialUtterance) -> bool:
        """Whether the pause is reached after which a whole command is taken."""
        return partial.quiet >= self._config.pause - _SLACK

    @property
    def sound(self) -> Samples:
        """Sound of the newest pass, shape (n,); empty before the first."""
        return frozen_samples(np.zeros(0)) if self._sound is None else self._sound

    def scores(self, phrases: Sequence[str]) -> dict[str, float]:
        """The recogniser's scores of phrases in the sound of the newest pass, computed once."""
        if self._sound is not None and not set(phrases) <= set(self._scores):
            self._scores = self._recognizer.score(self._sound, phrases)
        return self._scores

    def verify(self, phrase: str) -> float:
        """The recogniser's log-odds [nat] that the newest sound is a phrase; see Recognizer."""
        if phrase not in self._verified:
            self._verified[phrase] = self._recognizer.verify(self.sound, phrase)
        return self._verified[phrase]

    def _is_due(self, partial: PartialUtterance, frame: Frame, time: float, is_turn: bool) -> bool:
        """Whether the sound is worth a pass now."""
        if partial.utterance.speech_end < self._ignored_until:
            return False
        if partial.utterance.is_complete:
            return self._has_news
        if not (self._config.is_enabled and self._has_news):
            return False
        if is_turn:  # behind, too: what is decided now must be of all the sound
            return True
        if self._clock() - frame.stamp - frame.duration > self._config.max_backlog:
            self._observer(SideInput(SideInputKind.BEHIND, frame.first_sample))
            return False
        decoded_at = time if self._decoded_at is None else self._decoded_at
        since = time - decoded_at + _SLACK
        if self.is_settled(partial) or since < self._config.partial_interval:
            return self.is_settled(partial)
        cost = 0.0 if frame.is_moving else min(self._costs)
        if cost > self._config.partial_interval and since < cost / _BUSY:
            self._observer(SideInput(SideInputKind.BEHIND, frame.first_sample))
            return False
        return True

    def _decode(self, partial: PartialUtterance, time: float, part: float, is_moving: bool) -> None:
        begun = self._clock()
        whole = partial.utterance.samples
        is_final = partial.utterance.is_complete or self.is_settled(partial)
        self._sound = self._end_of(whole, self._config.window, is_final)
        self.is_window = len(whole) > round(self._config.window * RATE)
        self.part = None
        if part > 0.0:
            is_all = len(whole) <= round(part * RATE)  # encoded once, then
            sound = self._sound if is_all else self._end_of(whole, part, is_final)
            hopeless = never_hopeless if is_moving else self._is_hopeless  # a sentence counts, too
            self.part = self._recognizer.transcribe(sound, hopeless)
        self.transcript = self._recognizer.transcribe(self._sound, self._is_hopeless)
        if self.transcript.text:
            self.worded_at = time
        self._decoded_at, self._scores, self._verified = time, {}, {}
        self._has_news = not is_final
        self._costs.append(self._clock() - begun)

    def _end_of(self, whole: Samples, seconds: float, is_final: bool) -> Samples:
        """The last part of a sound, of `seconds` at most. From shape (n,) to (m,)."""
        sound = last(whole, seconds)
        if not is_final:
            return sound
        silence = np.zeros(round(self._config.silence_added * RATE), np.float32)
        # the recogniser is surer of a last word that it hears end
        return frozen_samples(np.concatenate([sound, silence]))
