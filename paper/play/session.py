# SPDX-License-Identifier: BSD-3-Clause
"""One voice speaks as a plan asks; the robot does what it heard."""

from __future__ import annotations

import time
from pathlib import Path
from random import Random

from rich.console import Console

from paper.config import ExperimentConfig, PaperVoiceConfig
from paper.play.plan import COMMANDS, MOTIONS, PhrasePlan, Planned, TensionRange
from paper.play.speaker import Speaker
from paper.play.stage import PaperStage, stage
from paper.play.watch import Happened
from rst_control.config import load_motion_config


def tension_limits() -> TensionRange:
    """What the controller's settings allow the pulls to ask for."""
    tension = load_motion_config().controller.tension
    return TensionRange(tension.minimum, tension.maximum, tension.step_tension)


def run(
    voice: PaperVoiceConfig,
    config: ExperimentConfig,
    repetitions: int,
    folder: Path,
    console: Console,
) -> None:
    """Play the session of one voice.

    Args:
        voice: Who speaks.
        config: Settings.
        repetitions: Of each command.
        folder: Of the session.
        console: For the progress.

    Raises:
        RuntimeError: The system or the voice failed.
        OSError: There is no virtual microphone.
    """
    speaker = Speaker(voice, config, config.seed)
    for command in COMMANDS:
        speaker.prepare(command, repetitions)
    order = f"{config.seed} {voice.name}"
    plan = PhrasePlan(repetitions, config.talk_share, config.talk, tension_limits(), order)
    with stage(config, folder, lambda part: console.print(f"  {part} ready")) as scene:
        _Session(scene, plan, speaker, config, console).play()


class _Session:
    """Goes from phrase to phrase as soon as the system is ready for the next."""

    def __init__(
        self,
        scene: PaperStage,
        plan: PhrasePlan,
        speaker: Speaker,
        config: ExperimentConfig,
        console: Console,
    ) -> None:
        self._stage, self._watch, self._plan = scene, scene.watch, plan
        self._speaker, self._config, self._console = speaker, config, console
        self._prompter = Speaker(config.prompter, config, config.seed)
        self._rng = Random(f"{config.seed} pauses {speaker.voice.name}")
        self._count, self._begin = 0, time.monotonic()

    def play(self) -> None:
        """Say all phrases of the plan."""
        while planned := self._plan.next(self._watch.situation()):
            began = time.time()
            heard = self._say(planned)
            if heard is not None and heard.command in MOTIONS:
                self._let_move(heard, planned, began)
            self._watch.rest(self._config.rest_within)
            time.sleep(self._rng.uniform(*self._config.pause))

    def _let_move(self, heard: Happened, planned: Planned, began: float) -> None:
        """Wait for the begin of a motion and interrupt it where that is planned."""
        within = self._config.answer_within
        if not self._watch.started(heard.command, began, within):
            return
        if planned.stop_at and heard.command == planned.command:
            self._interrupt(planned)

    def _interrupt(self, planned: Planned) -> None:
        if not self._watch.phase(planned.stop_at, self._config.rest_within):
            return
        time.sleep(self._rng.uniform(*self._config.into_motion))
        if self._watch.is_moving:
            self._say(self._plan.interrupt(), inside=planned.command)

    def _say(self, planned: Planned, inside: str = "") -> Happened | None:
        """Say one phrase and wait for what is decided and answered; show it."""
        self._count += 1
        speaker = self._speaker if planned.is_counted else self._prompter
        spoken = speaker.say(planned.words)
        trial = self._stage.say(self._count, spoken, planned.command, planned.is_counted, inside)
        heard = self._watch.heard(trial.began, trial.ended, self._config.decide_within)
        answer = None
        if heard is not None and heard.command:
            answer = self._watch.answer(heard.command, trial.began, self._config.answer_within)
        self._show(planned, inside, heard, answer)
        return heard

    def _show(
        self, planned: Planned, inside: str, heard: Happened | None, answer: Happened | None
    ) -> None:
        taken = heard.command if heard else ""
        is_right = taken == planned.command
        outcome = f"heard {taken!r}" if taken else f"no command: {heard.words if heard else ''}"
        if answer is not None and answer.kind == "refused":
            outcome += f", refused: {answer.words}"
        who = "" if planned.is_counted else "prompter: "
        where = f" (in the motion of {inside!r})" if inside else ""
        minutes = (time.monotonic() - self._begin) / 60.0
        self._console.print(
            f"  {minutes:5.1f} min, {self._plan.left:3d} to go  {who}{planned.words!r}{where}: "
            f"{outcome}",
            style="" if is_right else "yellow",
            highlight=False,
            markup=False,
        )
