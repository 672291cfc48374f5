# SPDX-License-Identifier: BSD-3-Clause
"""The whole system on its own master, with a room to speak in: what every session stands on."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path

import rospy

from paper.config import ExperimentConfig
from paper.judging.trials import SpokenTrial, append
from paper.play.room import PaperRoom
from paper.play.speaker import SpokenPhrase
from paper.play.watch import SessionWatch
from support.launched_system import System

SOUND_TIME = 20.0  # [s] allowed for the first sound to be heard
SOUNDS = "phrases"  # folder of what was played


@dataclass(frozen=True)
class PaperStage:
    """A running system and what is needed to speak to it."""

    system: System
    room: PaperRoom
    watch: SessionWatch
    folder: Path

    def say(
        self, index: int, spoken: SpokenPhrase, command: str, is_counted: bool, inside: str
    ) -> SpokenTrial:
        """Speak a phrase, keep it as a trial and put on record what it means.

        Args:
            index: Of the trial.
            spoken: The phrase.
            command: Meant; empty: none.
            is_counted: Whether it is a repetition of the experiment.
            inside: Motion that it interrupts; empty: none.

        Raises:
            RuntimeError: A part of the system has ended, or no sound could be played.
        """
        if not self.system.is_running():
            raise RuntimeError("a part of the system ended during the session")
        name = f"{SOUNDS}/{index:04d}.wav"
        began, ended = self.room.say(spoken, self.folder / name, lambda: self.watch.intend(command))
        trial = SpokenTrial(
            index=index,
            command=command,
            words=spoken.words,
            sound=name,
            began=began,
            ended=ended,
            rate=round(spoken.rate, 3),
            pitch=round(spoken.pitch, 3),
            is_counted=is_counted,
            interrupts=inside,
        )
        append(self.folder, trial)
        return trial


@contextmanager
def stage(
    config: ExperimentConfig, folder: Path, say: Callable[[str], None]
) -> Iterator[PaperStage]:
    """Bring the system up with its room, recorded into a folder.

    Args:
        config: Settings.
        folder: Of the session; made if missing.
        say: Gets the name of what has come up.

    Raises:
        RuntimeError: A part does not come up.
        OSError: There is no virtual microphone.
    """
    (folder / SOUNDS).mkdir(parents=True, exist_ok=True)
    with ExitStack() as stack:
        room = stack.enter_context(PaperRoom(config.snr_db, config.seed))
        system = System(folder / "launch.log", room.microphone.environment)
        stack.enter_context(system)
        rospy.init_node("paper", anonymous=True, disable_signals=True)
        watch = stack.enter_context(SessionWatch())
        system.launch_session(folder, source="microphone", device=room.microphone.device)
        sound: dict[str, threading.Event] = {"sound": watch.hears_sound}
        system.wait_for({**watch.ready, **sound}, say)
        watch.wait_for_recorder()
        yield PaperStage(system, room, watch, folder)
