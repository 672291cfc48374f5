# SPDX-License-Identifier: BSD-3-Clause
"""What to say next: each command so many times, only where the dialogue allows it.

The plan follows the robot, not a list: it is asked again after every phrase, with the state that
came of it. So a command that was missed, refused or stopped needs no repair; the next phrase is
one that makes sense in the state as it is.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from random import Random

HEY_ROBOT, TENSE, RELEASE = "hey robot", "tense", "release"
PULL_MORE, PULL_LESS, STOP, TERMINATE = "pull more", "pull less", "stop", "terminate"
COMMANDS = (HEY_ROBOT, TENSE, RELEASE, PULL_MORE, PULL_LESS, STOP, TERMINATE)
MOTIONS = (TENSE, RELEASE, PULL_MORE, PULL_LESS)
PATIENCE = 3  # times in a row that a phrase may fail in a situation before the prompter says it
MARGIN = 0.1  # [N] the controller steps from its target, and what is measured is not quite that
FARTHEST = 4  # times as many phrases as planned, after which the plan gives up
# Phases of each motion at whose begin "stop" may be said.
PHASES = {TENSE: ("reach", "pull", "pull"), RELEASE: ("ease",)}
STEP_PHASES = ("step",)


@dataclass(frozen=True)
class RobotDialogue:
    """The dialogue and the robot, at rest."""

    is_listening: bool  # the voice part is in active mode
    is_active: bool  # the controller is
    is_halted: bool
    is_held: bool  # the jaws hold tissue
    tension: float = 0.0  # [N] pulled to, or measured


@dataclass(frozen=True)
class TensionRange:
    """What "pull more" and "pull less" may ask for."""

    minimum: float  # [N]
    maximum: float  # [N]
    step: float  # [N]


@dataclass(frozen=True)
class Planned:
    """One phrase to say."""

    command: str  # empty: it is none and must do nothing
    words: str
    stop_at: str = ""  # phase of its motion at which "stop" is to be said; empty: none
    is_counted: bool = True  # False: the prompter says it, so that the dialogue can go on


def allowed(situation: RobotDialogue, limits: TensionRange) -> tuple[str, ...]:
    """Commands that the robot takes at rest in a situation, "stop" apart."""
    if situation.is_halted and situation.is_active and situation.is_listening:
        return HEY_ROBOT, TERMINATE
    if situation.is_halted or not situation.is_active or not situation.is_listening:
        return (HEY_ROBOT,)
    if not situation.is_held:
        return TENSE, TERMINATE
    pulls = []
    if situation.tension + limits.step + MARGIN <= limits.maximum:
        pulls.append(PULL_MORE)
    if situation.tension - limits.step - MARGIN >= limits.minimum:
        pulls.append(PULL_LESS)
    return RELEASE, TERMINATE, *pulls


class PhrasePlan:
    """Draws phrase after phrase until every command has its repetitions, and no more of them.

    What must be said again, so that the dialogue can go on, is said by the prompter.
    """

    def __init__(
        self,
        repetitions: int,
        talk_share: float,
        talk: tuple[str, ...],
        limits: TensionRange,
        seed: str,
    ) -> None:
        """Begin.

        Args:
            repetitions: Of each command.
            talk_share: Share of all phrases that are no command.
            talk: Such phrases; each is said before any is said again.
            limits: Of the tension.
            seed: Of the order.
        """
        self.remaining = Counter(dict.fromkeys(COMMANDS, repetitions))
        commands = self.remaining.total()
        self._talk_left = round(commands * talk_share / (1.0 - talk_share)) if talk else 0
        self._limits, self._rng = limits, Random(seed)
        self._talk, self._heap = talk, list[str]()
        self._left = FARTHEST * (commands + self._talk_left)
        self._last, self._in_a_row = ("", RobotDialogue(False, False, False, False)), 0

    @property
    def left(self) -> int:
        """Number of phrases that are still wanted."""
        return max(self.remaining.total(), 0) + self._talk_left

    def next(self, situation: RobotDialogue) -> Planned | None:
        """Choose what to say at rest; None when all has been said or the plan gave up."""
        if self.left == 0 or self._left <= 0:
            return None
        self._left -= 1
        if self._rng.random() < self._talk_left / self.left:
            self._talk_left -= 1
            return Planned("", self._some_talk())
        command = self._choose(situation)
        is_counted = not self._is_stuck(command, situation) and self.remaining[command] > 0
        phase = self._phase_to_stop_in(command)
        if is_counted:
            self._said(command)
        return Planned(command, command, phase, is_counted)

    def interrupt(self) -> Planned:
        """Say "stop" in the motion that is under way."""
        self._said(STOP)
        return Planned(STOP, STOP)

    def _said(self, command: str) -> None:
        self.remaining[command] -= 1

    def _some_talk(self) -> str:
        if not self._heap:
            self._heap = list(self._talk)
            self._rng.shuffle(self._heap)
        return self._heap.pop()

    def _choose(self, situation: RobotDialogue) -> str:
        """Draw among the allowed ones in proportion to what remains; else what leads there."""
        choices = allowed(situation, self._limits)
        weights = [self.remaining[command] for command in choices]
        if any(weights):
            return self._rng.choices(choices, weights)[0]
        return self._bridge(situation, choices)

    def _bridge(self, situation: RobotDialogue, choices: tuple[str, ...]) -> str:
        """A command that needs no repetition any more, on the way to one that does."""
        if len(choices) == 1 or situation.is_halted:
            return HEY_ROBOT
        if not situation.is_held:
            needs_tissue = any(self.remaining[c] for c in (RELEASE, PULL_MORE, PULL_LESS, STOP))
            return TENSE if needs_tissue else TERMINATE
        if self.remaining[PULL_MORE] or self.remaining[PULL_LESS] or self.remaining[STOP]:
            pulls = [c for c in choices if c in (PULL_MORE, PULL_LESS)]
            return self._rng.choice(pulls or [RELEASE])
        return RELEASE if self.remaining[TENSE] else TERMINATE

    def _phase_to_stop_in(self, command: str) -> str:
        motions = sum(self.remaining[c] for c in MOTIONS)
        if command not in MOTIONS or not self.remaining[STOP]:
            return ""
        if self._rng.random() * max(motions, 1) > self.remaining[STOP]:
            return ""
        return self._rng.choice(PHASES.get(command, STEP_PHASES))

    def _is_stuck(self, command: str, situation: RobotDialogue) -> bool:
        """Tell whether the dialogue hangs on a phrase that failed too often in a row."""
        if command not in (HEY_ROBOT, TENSE, RELEASE):
            return False
        now = (command, situation)
        self._in_a_row = self._in_a_row + 1 if now == self._last else 0
        self._last = now
        if self._in_a_row < PATIENCE:
            return False
        self._in_a_row = 0
        return True
