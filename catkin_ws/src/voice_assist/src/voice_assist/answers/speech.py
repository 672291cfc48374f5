# SPDX-License-Identifier: BSD-3-Clause
"""Spoken answers as files, made once, and played one at a time with word of when they sound."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path
from tempfile import TemporaryDirectory
from threading import Lock
from typing import Final

import numpy as np
import soundfile

from voice_assist.answers.sentences import catalogue
from voice_assist.answers.voices import Speak, choose_voice
from voice_assist.answers.word_check import WordCheck
from voice_assist.config.alarms import SpeechConfig
from voice_assist.config.commands import CommandsConfig
from voice_assist.config.texts import texts_of
from voice_assist.errors import AudioError
from voice_assist.types import RATE

LONGEST: Final = 1.5  # [s] of an answer: a "stop" has to be heard over it
SILENCE: Final = 0.05  # [s] that is played to find out whether there is a loudspeaker
_TAIL: Final = 0.05  # [s] of silence after an answer, so that no device cuts its end

IsCut = Callable[[], bool]
Play = Callable[[Path, float, IsCut], None]  # a file of so many seconds, to its end or until cut


class SpokenAnswers:
    """Sentences that may be said, as a context: inside it their sound lies in a folder.

    Args:
        config: Who speaks, how fast and how loud.
        commands: All that can be said, which no answer may hold.
        play: Plays a file; raises AudioError where it cannot be heard.
        announce: Called with True before a sentence sounds, and with False after it.
        report: Called with what is not said, and why.
    """

    def __init__(
        self,
        config: SpeechConfig,
        commands: CommandsConfig,
        play: Play,
        announce: Callable[[bool], None],
        report: Callable[[str], None],
    ) -> None:
        self._config, self._commands, self._texts = config, commands, texts_of(commands)
        self._play, self._announce, self._report = play, announce, report
        self._lock = Lock()  # of the folder, which may go while sentences are still made
        self._folder: TemporaryDirectory[str] | None = None
        self._durations: dict[str, float] = {}  # [s] of each sentence that may be said

    def __enter__(self) -> SpokenAnswers:
        self._folder = TemporaryDirectory(prefix="voice_assist_answers_")
        return self

    def __exit__(self, *_: object) -> None:
        with self._lock:
            self._durations.clear()
            if self._folder is not None:
                self._folder.cleanup()
                self._folder = None

    def prepare(self, sentences: Iterable[str] = catalogue()) -> None:
        """Make the sound of each sentence that may be said, and try the loudspeaker.

        Args:
            sentences: English; said in the language of the commands.

        Raises:
            ModelError: What speaks is not installed, or refuses the voice.
        """
        voice = choose_voice(self._config, self._commands.language)
        check = WordCheck(self._commands)
        for sentence in map(self._texts, sentences):
            why = check.objection(sentence)
            with self._lock:
                if self._folder is None:
                    return
                why = why or self._make(voice, sentence)
            if why:
                self._report(f"{sentence!r} is not said: {why}")
        self._try_loudspeaker()

    def duration(self, sentence: str) -> float:
        """How long a sentence sounds [s]; 0 where it is not said."""
        return self._durations.get(sentence, 0.0)

    def say(self, sentence: str, is_cut: IsCut) -> None:
        """Say a sentence to its end, or until `is_cut` says so; nothing where it may not be said.

        Raises:
            AudioError: It cannot be heard.
        """
        duration = self._durations.get(sentence)
        if duration is None or self._folder is None or is_cut():
            return
        self._announce(True)
        try:
            self._play(self._path(sentence), duration, is_cut)
        finally:
            self._announce(False)

    def _try_loudspeaker(self) -> None:
        """Report one that is missing; it may come later, so each answer is tried all the same."""
        with self._lock:
            if self._folder is None:
                return
            silence = self._write("silence", np.zeros(round(SILENCE * RATE), np.float32))
        try:
            self._play(silence, SILENCE, lambda: False)
        except (AudioError, OSError) as error:
            self._report(f"no answer is heard: {error}; each is tried all the same")

    def _make(self, voice: Speak, sentence: str) -> str:
        """Write the sound of a sentence; returns why it may not be said."""
        sound = voice(sentence)
        duration = len(sound) / RATE
        if not 0.0 < duration <= LONGEST:
            return f"it lasts {duration:.2f} s, allowed: up to {LONGEST:.1f} s"
        loud = np.float32(10.0 ** (self._config.volume_db / 20.0)) * sound
        self._write(sentence, np.concatenate([loud, np.zeros(round(_TAIL * RATE), np.float32)]))
        self._durations[sentence] = duration
        return ""

    def _write(self, name: str, sound: np.ndarray[tuple[int], np.dtype[np.float32]]) -> Path:
        path = self._path(name)
        soundfile.write(str(path), sound, RATE, subtype="PCM_16")
        return path

    def _path(self, name: str) -> Path:
        if self._folder is None:
            raise AudioError("the answers are not there; enter them first")
        return Path(self._folder.name) / f"{name.replace(' ', '_')}.wav"
