# SPDX-License-Identifier: BSD-3-Clause
"""Enrolment step by step for a remote caller, such as a screen."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from typed_config import ConfigError
from voice_assist.config import VoiceConfig
from voice_assist.config.enrolment import EnrolmentConfig
from voice_assist.enrolment.build import build, require_adaptable
from voice_assist.enrolment.takes.checks import TakeCheck
from voice_assist.enrolment.takes.recording import record
from voice_assist.enrolment.takes.script import EnrolmentScript, EnrolmentStep
from voice_assist.errors import VoiceError
from voice_assist.profile.manifest import ACTIVE
from voice_assist.profile.profile import VoiceProfile, create_profile, names, open_profile
from voice_assist.recognizer.recognizer import Recognizer
from voice_assist.types import Frame

ACTIONS = ("next", "record", "learn")
ARMED = "the robot listens to commands: say terminate before you enrol"
KEPT = "the profile stays as it was"


@dataclass(frozen=True)
class ActionResult:
    """The answer to one action of enrolment."""

    success: bool
    message: str = ""
    step: EnrolmentStep | None = None  # what comes next


class EnrolmentService:
    """Takes one action at a time and refuses others meanwhile."""

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
            voice: Active settings, without a profile.
            config: Of enrolment.
            base: Recogniser that profiles are made on top of.
            root: Folder of all profiles.
            listen: Gives the sound from now on.
            is_armed: Whether a spoken command would now move the robot.

        Raises:
            VoiceProfileError: The recogniser cannot be adapted.
        """
        self._voice, self._config, self._root = voice, config, root
        self._base = require_adaptable(base)
        self._listen, self._is_armed = listen, is_armed
        self._check = TakeCheck(config.checks, voice.commands, base)
        self._scripts: dict[str, EnrolmentScript] = {}
        self._busy = threading.Lock()

    def __call__(self, name: str, action: str) -> ActionResult:
        """Carry out an action; errors are reported in the result."""
        if action not in ACTIONS:
            return ActionResult(False, f"action {action!r}, allowed: {', '.join(ACTIONS)}")
        if not self._busy.acquire(blocking=False):
            return ActionResult(False, "another action is under way")
        try:
            return self._act(name, action)
        except (VoiceError, ConfigError) as error:
            return ActionResult(False, str(error))
        finally:
            self._busy.release()

    def _act(self, name: str, action: str) -> ActionResult:
        profile = self._profile(name)
        if action == "learn":
            if self._is_armed():  # it takes minutes of a core
                return ActionResult(False, ARMED)
            notes: list[str] = []
            args = profile, self._voice, self._config, self._base
            problems = build(*args, on_note=notes.append)
            if problems and profile.manifest.state == ACTIVE:
                problems = (*problems, KEPT)
            return ActionResult(not problems, "; ".join(problems or notes))
        script = self._script(name, profile)
        step = script.next()
        if action == "next" or step is None:
            return ActionResult(action == "next", "" if action == "next" else "all is there", step)
        if self._is_armed():
            return ActionResult(False, ARMED, step)
        sound = record(self._listen(), step.seconds, lambda *_: None)
        script.profile = open_profile(name, self._root)  # a terminal may have changed it meanwhile
        before = len(script.profile.manifest.takes)
        checked = script.offer(step, sound)
        is_kept = len(script.profile.manifest.takes) > before
        return ActionResult(is_kept, "; ".join(checked.problems), script.next())

    def _profile(self, name: str) -> VoiceProfile:
        """The profile as it lies on file, which a terminal may have changed or deleted."""
        if name in names(self._root):
            return open_profile(name, self._root)
        self._scripts.pop(name, None)
        return create_profile(name, self._base.model_hash, self._root)

    def _script(self, name: str, profile: VoiceProfile) -> EnrolmentScript:
        """The script that goes on; it counts what was unlike the base, which is on no file."""
        phrases = self._voice.commands.fixed_phrases
        new = EnrolmentScript(profile, self._config, phrases, self._check)
        script = self._scripts.setdefault(name, new)
        script.profile = profile
        return script
