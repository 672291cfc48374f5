# SPDX-License-Identifier: BSD-3-Clause
"""Decides from what was observed whether each step of the script happened."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

from demo.script import VOICES, Script, ScriptStep

STEP = 0.02  # [N] least change of tension that counts as more or less
SLACK = 0.05  # [N] tension that counts as none
EARLY = (
    0.2  # [s] by which the beginning of speech may be reported too early: clocks, noise before it
)
REST = 1e-4  # [m/s] path speed that counts as rest


@dataclass(frozen=True)
class ControllerSample:
    """The controller at one moment of the script."""

    time: float  # [s] since the first sound
    state: str
    active: bool
    halted: bool
    tissue_held: bool
    tension: float  # [N]
    path_speed: float  # [m/s]
    rcm_error: float  # [m]
    insertion: float  # [m] of the tip inside the trocar; negative outside


@dataclass(frozen=True)
class HeardUtterance:
    """One decision of the recogniser."""

    time: float  # [s] since the first sound
    transcript: str
    command: str  # empty: none


@dataclass(frozen=True)
class Done:
    """A command that the robot accepted, or a call that a device carried out."""

    time: float  # [s] since the first sound
    what: str  # command or phrase
    message: str  # the robot's reply; of a device empty


@dataclass
class Observed:
    """All that was seen of the session, in order of time."""

    states: list[ControllerSample] = field(default_factory=list)
    heard: list[HeardUtterance] = field(default_factory=list)
    done: list[Done] = field(default_factory=list)

    def between(self, begin: float, end: float) -> list[ControllerSample]:
        """States within [begin, end)."""
        return [s for s in self.states if begin <= s.time < end]


@dataclass(frozen=True)
class StepVerdict:
    """Whether one step happened."""

    step: ScriptStep
    happened: bool
    found: str  # what was seen, in words


def verdicts(script: Script, observed: Observed) -> list[StepVerdict]:
    """Judge every step of the script."""
    return [_judge(script, i, observed) for i in range(len(script.steps))]


def _judge(script: Script, index: int, observed: Observed) -> StepVerdict:
    step = script.steps[index]
    # A motion that is stopped next may begin while that is said: a busy machine hears late.
    end = script.end_of(index + (step.effect == "moving"))
    states = observed.between(step.at, end)
    if not states:
        return StepVerdict(step, False, "the controller said nothing")
    commands = [h.command for h in observed.heard if step.at <= h.time + EARLY < end and h.command]
    before = observed.between(step.at - 0.5, step.at) or states[:1]
    done = [one for one in observed.done if step.at <= one.time < end]
    if step.speaker not in VOICES:  # no word is heard, the robot's reply counts
        commands = [step.say for one in done if step.say.startswith(one.what)]
    happened = _effect_seen(step, states, before[-1], commands)
    if step.effect == "light":
        happened = step.say in commands and any(one.what == step.say for one in done)
    last = states[-1]
    words = f"taken: {', '.join(commands) or 'nothing'}; then {last.state}, {last.tension:.2f} N"
    return StepVerdict(step, happened, words)


def _effect_seen(
    step: ScriptStep,
    states: Sequence[ControllerSample],
    before: ControllerSample,
    commands: Sequence[str],
) -> bool:
    last = states[-1]
    at_rest = abs(last.path_speed) < REST
    moved = any(abs(s.path_speed) > REST for s in states)
    if step.effect == "nothing":
        return not commands and not moved
    if step.say not in commands:
        return False
    match step.effect:
        case "activated":
            return last.active and not last.halted
        case "tense":
            return last.tissue_held and before.tension < SLACK < last.tension and at_rest
        case "more":
            return last.tension > before.tension + STEP and last.tissue_held and at_rest
        case "less":
            return last.tension < before.tension - STEP and last.tissue_held and at_rest
        case "moving":
            return moved
        case "stopped":
            kept_grip = last.tissue_held == before.tissue_held
            return moved and last.halted and at_rest and kept_grip
        case "cleared":
            return before.halted and not last.halted
        case "released":
            return not last.tissue_held and last.tension < SLACK and at_rest
        case "standby":
            return not last.active
    return False


def worst_rcm_error(observed: Observed) -> float:
    """Largest RCM error while the tool moved in the patient [m]; no number when it never did."""
    states = (s for s in observed.states if s.insertion >= 0.0 and abs(s.path_speed) > REST)
    return max((s.rcm_error for s in states), default=math.nan)
