# SPDX-License-Identifier: BSD-3-Clause
"""Looks at an utterance again and again while it grows: when, and what was heard."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from voice_assist.config import EarlyConfig
from voice_assist.side_inputs import Circumstance, Kind, Witness, ignore
from voice_assist.types import RATE, Frame, Hypothesis, Loses, Samples, frozen_samples, never
from voice_assist.vad.segmenter import Growth, last

if TYPE_CHECKING:
    from voice_assist.recognizer.recognizer import Recognizer

_SLACK = 1e-6  # [s] so that sums of frame lengths reach their limits


class Hearing:
    """Transcripts and scores of one utterance.

    Looks are `partial_interval` apart while there is speech. One more comes once it has been quiet
    for `settle`; that one stands until there is speech again, so that at the end of the `pause`
    nothing is left to compute. Of a long utterance only the last `window` is ever heard, so that no
    look takes long: a command is short, and talk is none. Where the robot itself talks all the
    while, a look takes the very last part alone too, in which one word may stand by itself.
    """

    def __init__(
        self,
        recognizer: Recognizer,
        config: EarlyConfig,
        clock: Callable[[], float],
        witness: Witness = ignore,
        loses: Loses = never,
    ) -> None:
        """Start with a new utterance.

        Args:
            recognizer: Makes text of sound.
            config: When to look.
            clock: The one that stamps the frames [s].
            witness: Told of looks that are skipped because the sound comes too late.
            loses: Of the beginning of a text: whatever follows is not worth the time.
        """
        self._recognizer, self._config, self._clock = recognizer, config, clock
        self._witness, self._loses = witness, loses
        self.reset()

    def reset(self) -> None:
        """Start with a new utterance."""
        self.heard: Hypothesis | None = None  # newest transcript
        self.part: Hypothesis | None = None  # of the last part alone, at the same moment
        self.is_window = False  # it is only of the utterance's last part
        self.worded_at = float("-inf")  # [s] stream time of the newest look that heard a word
        self._looked_at: float | None = None  # [s] stream time of the newest look
        self._has_news = False  # there was speech since the newest look
        self._has_paused = False  # the pause was reached since there was speech
        self._ignored_until = float("-inf")  # [s] speech that ends before is not looked at
        self._sound: Samples | None = None  # of the newest look
        self._scores: dict[str, float] = {}

    def restart(self, growth: Growth) -> None:
        """Go on with the rest of the utterance only."""
        self.reset()
        self._ignored_until = growth.utterance.speech_end + self._config.min_rest

    def __call__(self, growth: Growth, frame: Frame, time: float, part: float = 0.0) -> bool:
        """Follow the utterance by a frame.

        Args:
            growth: The utterance with that frame.
            frame: The frame.
            time: Stream time of its end [s].
            part: Length of the last part that is looked at by itself too [s]; 0: none is.

        Returns:
            Whether a decision may have become possible.
        """
        if growth.quiet == 0.0:
            self._has_news, self._has_paused = True, False
        if self._looked_at is None:
            self._looked_at = time
        is_pause = growth.quiet >= self._config.pause - _SLACK
        is_turn = growth.utterance.is_complete or (is_pause and not self._has_paused)
        self._has_paused |= is_pause
        is_new = self._is_due(growth, frame, time, is_turn)
        if is_new:
            self._look(growth, time, part)
        return self.heard is not None and (is_new or is_turn)

    def is_settled(self, growth: Growth) -> bool:
        """Whether the newest transcript stands until there is speech again."""
        return growth.quiet >= self._config.settle - _SLACK

    @property
    def sound(self) -> Samples:
        """What the newest look was at, shape (n,); empty before the first."""
        return frozen_samples(np.zeros(0)) if self._sound is None else self._sound

    def scores(self, phrases: Sequence[str]) -> dict[str, float]:
        """The recogniser's scores of phrases in the sound of the newest look, computed once."""
        if self._sound is not None and not set(phrases) <= set(self._scores):
            self._scores = self._recognizer.score(self._sound, phrases)
        return self._scores

    def _is_due(self, growth: Growth, frame: Frame, time: float, is_turn: bool) -> bool:
        """Whether the sound is worth a look now."""
        if growth.utterance.speech_end < self._ignored_until:
            return False
        if growth.utterance.is_complete:
            return self._has_news
        if not (self._config.is_enabled and self._has_news):
            return False
        if self._clock() - frame.stamp - frame.duration > self._config.max_backlog:
            self._witness(Circumstance(Kind.BEHIND, frame.first_sample))
            return False
        looked_at = time if self._looked_at is None else self._looked_at
        is_time = time - looked_at >= self._config.partial_interval - _SLACK
        return is_time or is_turn or self.is_settled(growth)

    def _look(self, growth: Growth, time: float, part: float) -> None:
        whole = growth.utterance.samples
        is_final = growth.utterance.is_complete or self.is_settled(growth)
        self._sound = self._end_of(whole, self._config.window, is_final)
        self.is_window = len(whole) > round(self._config.window * RATE)
        self.heard = self._recognizer.transcribe(self._sound, self._loses)
        self.part = None
        if part > 0.0:
            sound = self._end_of(whole, part, is_final)
            self.part = self._recognizer.transcribe(sound, self._loses)
        if self.heard.text:
            self.worded_at = time
        self._looked_at, self._scores = time, {}
        self._has_news = not is_final

    def _end_of(self, whole: Samples, seconds: float, is_final: bool) -> Samples:
        """The last part of a sound, of `seconds` at most. From shape (n,) to (m,)."""
        sound = last(whole, seconds)
        if not is_final:
            return sound
        silence = np.zeros(round(self._config.silence_added * RATE), np.float32)
        # the recogniser is surer of a last word that it hears end
        return frozen_samples(np.concatenate([sound, silence]))
