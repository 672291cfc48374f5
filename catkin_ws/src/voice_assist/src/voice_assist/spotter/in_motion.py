# SPDX-License-Identifier: BSD-3-Clause
"""Two spotters as one: the second listens only while the robot moves, since it costs more."""

from __future__ import annotations

from voice_assist.spotter.spotter import NEWEST, Spotted, Spotting
from voice_assist.types import Frame


class SpotterInMotion:
    """Fires what either fires; the first alone gives the scores that the recogniser is joined with.

    To the second, sound from before the motion is silence.
    """

    def __init__(self, always: Spotting, in_motion: Spotting) -> None:
        """Join them.

        Args:
            always: Hears every frame.
            in_motion: Hears those in which the robot moves.
        """
        self._always, self._in_motion = always, in_motion

    def __call__(self, frame: Frame) -> Spotted | None:
        """Hear a frame; gives what is fired with it."""
        fired = self._always(frame)
        return (self._in_motion(frame) or fired) if frame.is_moving else fired

    def best(self, since: float, until: int = NEWEST) -> float | None:
        """Of the first; see Spotting."""
        return self._always.best(since, until)

    def reset(self) -> None:
        """Forget the stream so far."""
        self._always.reset()
        self._in_motion.reset()
