# SPDX-License-Identifier: BSD-3-Clause
"""The same plan as for a voice, pressed on a joystick's buttons by a program."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path
from random import Random

import rospy
import yaml
from rich.console import Console
from sensor_msgs.msg import JointState, Joy

from paper.config import ExperimentConfig
from paper.judging.outcomes import PhraseOutcome
from paper.play.plan import COMMANDS, MOTIONS, STOP, PhrasePlan, Planned
from paper.play.session import tension_limits
from paper.play.watch import Happened, SessionWatch
from support.launched_system import READY_TIME, System
from support.own_settings import copy_settings
from support.waiting import wait_until

HELD = 0.1  # [s] that a press lasts
SETTINGS = "settings"  # folder of the session's


def run(
    config: ExperimentConfig, repetitions: int, folder: Path, console: Console
) -> list[PhraseOutcome]:
    """Press the session.

    Args:
        config: Settings.
        repetitions: Of each command.
        folder: Of the session.
        console: For the progress.

    Raises:
        RuntimeError: The system failed.
    """
    plan = PhrasePlan(repetitions, 0.0, (), tension_limits(), f"{config.seed} pedal")
    with ExitStack() as stack:
        system = stack.enter_context(System(folder / "launch.log", {}))
        rospy.init_node("paper", anonymous=True, disable_signals=True)
        watch = stack.enter_context(SessionWatch())
        settings = own_settings(folder / SETTINGS)
        system.launch_session(folder, source="topic", pedal=True, config=settings)
        system.wait_for(watch.ready, lambda part: console.print(f"  {part} ready"))
        # the controller is ready before its robot is
        rospy.wait_for_message("joint_states", JointState, READY_TIME)
        return _PedalSession(watch, plan, config, console).play()


def own_settings(folder: Path) -> Path:
    """The package's settings with a button for each command."""
    file = copy_settings(folder, "/paper_*") / "pedal.yaml"
    given = yaml.safe_load(file.read_text(encoding="utf-8"))
    given["bindings"] = [
        {"input": f"button {i}", "above": 0.5, "does": "command", "command": command}
        for i, command in enumerate(COMMANDS)
    ]
    file.write_text(yaml.safe_dump(given), encoding="utf-8")
    return folder


class _PedalSession:
    """Goes from press to press as soon as the system is ready for the next."""

    def __init__(
        self, watch: SessionWatch, plan: PhrasePlan, config: ExperimentConfig, console: Console
    ) -> None:
        self._watch, self._plan, self._config, self._console = watch, plan, config, console
        self._rng = Random(f"{config.seed} pauses pedal")
        self._joy = rospy.Publisher("joy", Joy, queue_size=10)
        wait_until(lambda: self._joy.get_num_connections() > 1, "pedal node and recorder")
        self._publish(())  # nothing is pressed at the start
        self._outcomes: list[PhraseOutcome] = []

    def play(self) -> list[PhraseOutcome]:
        """Press all that the plan asks for."""
        while planned := self._plan.next(self._watch.situation()):
            answer, began = self._press(planned)
            if answer is not None and planned.command in MOTIONS and planned.stop_at:
                self._interrupt(planned, began)
            self._watch.rest(self._config.rest_within)
            time.sleep(self._rng.uniform(*self._config.pause))
        return self._outcomes

    def _interrupt(self, planned: Planned, began: float) -> None:
        within = self._config.answer_within
        if not self._watch.started(planned.command, began, within):
            return
        if self._watch.phase(planned.stop_at, self._config.rest_within):
            time.sleep(self._rng.uniform(*self._config.into_motion))
            if self._watch.is_moving:
                self._press(self._plan.interrupt())

    def _press(self, planned: Planned) -> tuple[Happened | None, float]:
        """Press and let go; keep what came of it. Nothing sounds, so no words are on record."""
        began = time.time()
        self._publish((COMMANDS.index(planned.command),))
        time.sleep(HELD)
        self._publish(())
        answer = self._watch.answer(planned.command, began, self._config.answer_within)
        acted = math.nan if answer is None else answer.time - began
        if answer is not None and answer.kind == "accepted" and planned.command in MOTIONS:
            self._watch.started(planned.command, began, self._config.answer_within)
            starts = self._watch.since(began, "motion_started")
            acted = starts[0].time - began if starts else math.nan
        is_refused = answer is not None and answer.kind == "refused"
        taken = [h.command or STOP for h in self._watch.since(began, "accepted", "stop_received")]
        self._outcomes.append(
            PhraseOutcome(
                command=planned.command,
                words=planned.command,
                taken=tuple(dict.fromkeys(taken)) or ((planned.command,) if is_refused else ()),
                refusal=answer.words if answer is not None and is_refused else "",
                is_counted=planned.is_counted,
                is_whole=True,
                decided=math.nan if answer is None else answer.time - began,
                acted=math.nan if is_refused else acted,
            )
        )
        said = "no answer" if answer is None else answer.kind
        line = f"  {self._plan.left:3d} to go  {planned.command!r}: {said}"
        self._console.print(line, highlight=False, markup=False)
        return answer, began

    def _publish(self, pressed: Sequence[int]) -> None:
        buttons = [int(i in pressed) for i in range(len(COMMANDS))]
        message = Joy(buttons=buttons, axes=[])
        message.header.stamp = rospy.Time.now()
        self._joy.publish(message)
