# SPDX-License-Identifier: BSD-3-Clause
"""Enrolment step by step for whoever asks from outside, such as a screen."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from typed_config import ConfigError
from voice_assist.config import VoiceConfig
from voice_assist.config.enrolment import EnrolmentConfig
from voice_assist.enrolment.build import build
from voice_assist.enrolment.checks import TakeCheck
from voice_assist.enrolment.recording import record
from voice_assist.enrolment.script import Session, Step
from voice_assist.errors import VoiceError
from voice_assist.profile.profile import Profile, create_profile, names, open_profile
from voice_assist.recognizer.recognizer import Recognizer
from voice_assist.types import Frame

ACTIONS = ("next", "record", "learn")


@dataclass(frozen=True)
class Told:
    """The answer to one action."""

    success: bool
    message: str = ""
    step: Step | None = None  # what comes next


class EnrolmentDesk:
    """Takes one action at a time; what is asked meanwhile is refused."""

    def __init__(
        self,
        voice: VoiceConfig,
        config: EnrolmentConfig,
        base: Recognizer,
        root: Path,
        listen: Callable[[], Iterator[Frame]],
        is_armed: Callable[[], bool],
    ) -> None:
        """Open for actions.

        Args:
            voice: Settings in force, without a profile.
            config: Of enrolment.
            base: Recogniser that profiles are made on top of.
            root: Folder of all profiles.
            listen: Gives the sound from now on.
            is_armed: Whether a spoken command would now move the robot.
        """
        self._voice, self._config, self._base, self._root = voice, config, base, root
        self._listen, self._is_armed = listen, is_armed
        self._check = TakeCheck(config.checks, voice.commands, base)
        self._sessions: dict[str, Session] = {}
        self._busy = threading.Lock()

    def __call__(self, name: str, action: str) -> Told:
        """Carry out an action; whatever goes wrong is told."""
        if action not in ACTIONS:
            return Told(False, f"action {action!r}, allowed: {', '.join(ACTIONS)}")
        if not self._busy.acquire(blocking=False):
            return Told(False, "another action is under way")
        try:
            return self._act(name, action)
        except (VoiceError, ConfigError) as error:
            return Told(False, str(error))
        finally:
            self._busy.release()

    def _act(self, name: str, action: str) -> Told:
        profile = self._profile(name)
        if action == "learn":
            notes: list[str] = []
            args = profile, self._voice, self._config, self._base
            problems = build(*args, noted=notes.append)
            return Told(not problems, "; ".join(problems or notes))
        session = self._session(name, profile)
        step = session.next()
        if action == "next" or step is None:
            return Told(action == "next", "" if action == "next" else "all is there", step)
        if self._is_armed():
            words = "the robot listens to commands: say terminate before you enrol"
            return Told(False, words, step)
        checked = session.offer(step, record(self._listen(), step.seconds, lambda *_: None))
        return Told(session.next() != step, "; ".join(checked.problems), session.next())

    def _profile(self, name: str) -> Profile:
        if name in self._sessions:
            return self._sessions[name].profile
        if name in names(self._root):
            return open_profile(name, self._root)
        return create_profile(name, self._base.model_hash, self._root)

    def _session(self, name: str, profile: Profile) -> Session:
        if name not in self._sessions:
            phrases = self._voice.commands.phrases
            self._sessions[name] = Session(profile, self._config, phrases, self._check)
        return self._sessions[name]
