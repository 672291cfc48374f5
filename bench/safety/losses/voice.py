# SPDX-License-Identifier: BSD-3-Clause
"""The voice node with a recogniser that hangs on SIGUSR1 and crashes on SIGUSR2.

It fails at its next decoder pass, and reports that on the topic `losses/failed`.
"""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Sequence
from typing import Any

import rospy
from std_msgs.msg import Float64

from voice_assist.assembly import make_recognizer
from voice_assist.config import VoiceConfig, load_voice_config
from voice_assist.recognizer.recognizer import Recognizer
from voice_assist.ros import voice_node
from voice_assist.types import Hypothesis, IsHopeless, Samples, never_hopeless


class Failing:
    """A recogniser that is well until a signal.

    Args:
        real: That hears until then.
    """

    def __init__(self, real: Recognizer) -> None:
        self._real, self._way = real, ""
        self.name, self.model_hash = real.name, real.model_hash
        self._failed = rospy.Publisher("losses/failed", Float64, queue_size=1)
        signal.signal(signal.SIGUSR1, lambda *_: self._fail("hang"))
        signal.signal(signal.SIGUSR2, lambda *_: self._fail("crash"))

    def transcribe(self, samples: Samples, is_hopeless: IsHopeless = never_hopeless) -> Hypothesis:
        """Text of the sound."""
        if self._way:
            self._failed.publish(Float64(data=time.monotonic()))
        if self._way == "hang":
            threading.Event().wait()
        if self._way == "crash":
            raise ArithmeticError("the recogniser crashed, as the bench asked")
        return self._real.transcribe(samples, is_hopeless)

    def score(self, samples: Samples, phrases: Sequence[str]) -> dict[str, float]:
        """Scores of phrases in the sound."""
        return self._real.score(samples, phrases)

    def verify(self, samples: Samples, phrase: str) -> float:
        """Log-odds of a phrase in the sound."""
        return self._real.verify(samples, phrase)

    def _fail(self, way: str) -> None:
        self._way = way


def main() -> None:
    """Run the node on the topic `audio_in`, with the settings of the package's files."""
    parts: dict[str, Any] = {
        "make_recognizer": lambda config: Failing(make_recognizer(config)),
        "node_settings": _config,
    }
    for name, part in parts.items():
        setattr(voice_node, name, part)
    voice_node.main()


def _config() -> VoiceConfig:
    return load_voice_config(audio__source="topic")


if __name__ == "__main__":
    main()
