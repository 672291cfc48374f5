# SPDX-License-Identifier: BSD-3-Clause
"""Decides whether a command may run: its whole path is checked before anything moves."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Final

import numpy as np

from rst_control.commands.camera_step import LookPlans, TiltOutOfRange
from rst_control.commands.insert_withdraw import InsertionPlans
from rst_control.commands.preconditions import Conditions, mode_refusal
from rst_control.commands.pull_by_distance import BlindPulls
from rst_control.commands.tense import choose_grasp
from rst_control.errors import (
    Collision,
    Infeasible,
    InsertionOutOfRange,
    JointLimitExceeded,
    NearSingular,
    NoGrasp,
    OutsideWorkspace,
    TrocarDrift,
)
from rst_control.kinematics.configuration import planning_joints
from rst_control.planning.plan import (
    Accepted,
    Grasp,
    Phase,
    PhaseKind,
    Plan,
    Rejected,
    Request,
    Situation,
)
from rst_control.planning.planner import Planner, along
from rst_control.trajectory.path import Path
from rst_control.types import BY_HAND, LOOKS, Command, Measurement, Reason, Vector

COMMANDS: Final = {command.value: command for command in Command}
PULLS: Final = (Command.PULL_MORE, Command.PULL_LESS)
MOTIONS: Final = (Command.TENSE, Command.RELEASE, *PULLS, *BY_HAND, *LOOKS)
MIN_ROOM: Final = 5e-4  # [m] of pull path left, below which pulling further makes no sense
ROUNDING: Final = 1e-9  # [m] that a path may be shorter than asked for
NEAR: Final = 2e-3  # [rad] that joints may be away from where the grasp says they are

REASONS: Final[dict[type[Infeasible], Reason]] = {
    JointLimitExceeded: Reason.JOINT_LIMIT,
    TrocarDrift: Reason.RCM_TOLERANCE,
    OutsideWorkspace: Reason.WORKSPACE,
    InsertionOutOfRange: Reason.INSERTION_DEPTH,
    Collision: Reason.COLLISION,
    NearSingular: Reason.SINGULAR,
    TiltOutOfRange: Reason.TILT_LIMIT,
}


class Verifier:
    """Turns a command and a situation into a plan or a refusal with its reason.

    Args:
        planner: For this robot and scene; its configuration holds all limits.
    """

    def __init__(self, planner: Planner) -> None:
        self._planner, self._config = planner, planner.config
        self._tension = planner.config.controller.tension
        self._blind = BlindPulls(self._tension)
        self._conditions = Conditions(planner)
        self._insertion, self._look = InsertionPlans(planner), LookPlans(planner)

    def warm_up(self) -> None:
        """Compile or load all that verification calls."""
        self._planner.warm_up()
        self._insertion.warm_up()

    def __call__(self, request: Request, situation: Situation) -> Accepted | Rejected:
        """Decide; never raises for what a person may ask."""
        command = COMMANDS.get(" ".join(request.words.lower().split()))
        if command is None:
            known = ", ".join(f'"{words}"' for words in COMMANDS)
            words = f'unknown command "{request.words[:40]}", known: {known}'
            return Rejected(Reason.UNKNOWN_COMMAND, words)
        refusal = mode_refusal(command, situation) or self._conditions.refusal(command, situation)
        if refusal is not None:
            return refusal
        if not all(math.isfinite(v) and v >= 0.0 for v in (request.tension, request.distance)):
            words = f"asked for {request.tension} N and {request.distance} m, allowed 0 and above"
            return Rejected(Reason.TENSION_LIMIT, words)
        try:
            return self._plan(command, request, situation)
        except Infeasible as error:
            cause = error.reasons[0] if isinstance(error, NoGrasp) else error
            reason = REASONS.get(type(cause), Reason.UNREACHABLE)
            return Rejected(reason, f'cannot "{command.value}": {error}')

    # The command itself.

    def _plan(
        self, command: Command, request: Request, situation: Situation
    ) -> Accepted | Rejected:
        measured = situation.measurement
        if command not in MOTIONS or measured is None:
            return Accepted(Plan(command, _words(command)))
        if command in (*BY_HAND, *LOOKS):
            plans = self._insertion if command in BY_HAND else self._look
            return plans(command, self._joints(situation, measured), measured)
        if command is Command.TENSE:
            return self._tense(request, situation, measured)
        if not measured.gripped:
            words = f'nothing grasped; "{command.value}" needs tissue between the jaws'
            return Rejected(Reason.NOTHING_GRASPED, words)
        if command is Command.RELEASE:
            return Accepted(self._release(situation, measured))
        if self._by_distance(request) or self._blind.why(measured):
            return self._pull_distance(command, request, situation, measured)
        return self._pull_tension(command, request, situation, measured)

    def _tense(
        self, request: Request, situation: Situation, measured: Measurement
    ) -> Accepted | Rejected:
        if measured.gripped:
            words = f"tissue already grasped, at {measured.tension:.2f} N"
            return Rejected(Reason.ALREADY_GRASPED, words)
        target = request.tension or self._tension.initial
        refusal = self._target(target) or self._current(measured)
        if refusal is not None:
            return refusal
        chosen = choose_grasp(self._planner, self._joints(situation, measured))
        pull = chosen.pull
        why = self._blind.why(measured)
        furthest = request.distance or (self._blind.way(target) if why else pull.length)
        if furthest > pull.length + ROUNDING:
            return self._too_far(furthest, pull.length)
        furthest = min(furthest, pull.length)
        if why and furthest > (most := self._blind.way(target)) + ROUNDING:
            return self._too_far(furthest, most)
        speed = self._config.controller.speed
        phases = [Phase(PhaseKind.OPEN, opening=self._config.controller.jaws.open)]
        phases += [self._along(PhaseKind.REACH, way, speed.tip_speed) for way in chosen.reach]
        phases.append(Phase(PhaseKind.CLOSE, opening=0.0))
        way = self._along(PhaseKind.PULL, pull, speed.pull_speed)
        tension = None if why else target
        phases.append(replace(way, target=furthest, tension=tension))
        grasp = Grasp(pull, chosen.retreat, 0.0 if tension else furthest, tension)
        words = f"reaches, grasps and pulls to {target:.2f} N"
        if why:
            words = f"reaches, grasps and pulls {furthest * 1e3:.1f} mm{self._blind.words(why)}"
        return Accepted(Plan(Command.TENSE, words, tuple(phases), grasp))

    def _release(self, situation: Situation, measured: Measurement) -> Plan:
        """Out by ways checked when it grasped: back along the pull, then out of the tissue."""
        grasp = self._remembered(situation, measured)
        speed = self._config.controller.speed.tip_speed
        if grasp is None:
            eases = self._unplanned_retreat(situation, measured)
        else:
            back = self._along(PhaseKind.EASE, grasp.pull, speed)
            eases = [replace(back, start=grasp.s, target=0.0)] if grasp.s > 0.0 else []
            eases.append(self._along(PhaseKind.EASE, grasp.retreat, speed))
        opening = Phase(PhaseKind.OPEN, opening=self._config.controller.jaws.open)
        return Plan(Command.RELEASE, "opens the jaws and eases off", (opening, *eases))

    def _unplanned_retreat(self, situation: Situation, measured: Measurement) -> list[Phase]:
        """A way out from wherever it stands; where there is none, opening the jaws has to do."""
        speed = self._config.controller.speed.tip_speed
        try:
            q, ways = self._seated(situation, measured)
            ways = (*ways, self._planner.retreat(q))
        except Infeasible:
            return []
        return [self._along(PhaseKind.EASE, way, speed) for way in ways]

    def _pull_tension(
        self, command: Command, request: Request, situation: Situation, measured: Measurement
    ) -> Accepted | Rejected:
        grasp, seats = self._held(situation, measured)
        step = request.tension or self._tension.step_tension
        base = self._base_tension(situation, grasp, measured)
        target = base + step
        if command is Command.PULL_LESS:  # from above what is allowed, all the way back to it
            target = min(base - step, self._tension.maximum)
        refusal = self._target(target)
        if command is Command.PULL_MORE:
            refusal = refusal or self._current(measured) or self._room(grasp)
        if refusal is not None:
            return refusal
        phase = self._along(PhaseKind.STEP, grasp.pull, self._config.controller.speed.pull_speed)
        phase = replace(phase, start=grasp.s, target=grasp.pull.length, tension=target)
        words = f"pulls {_direction(command)}: {base:.2f} N to {target:.2f} N"
        return Accepted(Plan(command, words, (*seats, phase), replace(grasp, tension=target)))

    def _pull_distance(
        self, command: Command, request: Request, situation: Situation, measured: Measurement
    ) -> Accepted | Rejected:
        grasp, seats = self._held(situation, measured)
        why, is_more = self._blind.why(measured), command is Command.PULL_MORE
        step = request.distance or self._tension.step_distance
        if why and not request.distance:
            step = self._blind.way(request.tension or self._tension.step_tension)
        target = grasp.s + step if is_more else grasp.s - step
        most = min(grasp.pull.length, self._blind.most) if why else grasp.pull.length
        if target < 0.0 or (is_more and target > most + ROUNDING):
            return self._too_far(target, most)
        if is_more:
            predicted = None if why else self._predicted(grasp, step, measured)
            refusal = predicted or self._current(measured)
            if refusal is not None:
                return refusal
        phase = self._along(PhaseKind.STEP, grasp.pull, self._config.controller.speed.pull_speed)
        ceiling = self._tension.maximum if is_more and not why else None
        phase = replace(phase, start=grasp.s, target=target, tension=ceiling)
        words = f"pulls {_direction(command)}: {grasp.s * 1e3:.1f} mm to {target * 1e3:.1f} mm"
        words += self._blind.words(why) if why else ""
        grasp = replace(grasp, s=target, tension=None)
        return Accepted(Plan(command, words, (*seats, phase), grasp))

    # Parts of the decision.

    def _by_distance(self, request: Request) -> bool:
        if request.tension or request.distance:
            return not request.tension
        return self._tension.step_by == "distance"

    def _joints(self, situation: Situation, measured: Measurement) -> Vector:
        joints = measured.position if situation.setpoint is None else situation.setpoint
        return planning_joints(joints)[0]

    def _remembered(self, situation: Situation, measured: Measurement) -> Grasp | None:
        grasp = situation.grasp
        if grasp is None or situation.is_moving:
            return grasp
        return grasp if _is_near(self._joints(situation, measured), grasp) else None

    def _held(self, situation: Situation, measured: Measurement) -> tuple[Grasp, tuple[Phase, ...]]:
        """The grasp, planned from here if none is remembered, and what comes before a pull."""
        grasp = self._remembered(situation, measured)
        if grasp is not None:
            return grasp, ()
        q, ways = self._seated(situation, measured)
        speed = self._config.controller.speed.pull_speed
        seats = tuple(self._along(PhaseKind.STEP, way, speed) for way in ways)
        return Grasp(self._planner.pull(q), self._planner.retreat(q)), seats

    def _seated(
        self, situation: Situation, measured: Measurement
    ) -> tuple[Vector, tuple[Path, ...]]:
        q = self._joints(situation, measured)
        ways = self._planner.route(q)
        return (ways[-1].end if ways else q), ways

    def _base_tension(self, situation: Situation, grasp: Grasp, measured: Measurement) -> float:
        """What a step starts from: the target while pursued or held, else what is measured."""
        target = grasp.tension
        if target is None:
            return measured.tension
        is_held = abs(measured.tension - target) <= 2.0 * self._tension.tolerance
        return target if situation.is_moving or is_held else measured.tension

    def _along(self, kind: PhaseKind, path: Path, speed: float) -> Phase:
        return along(self._planner, kind, path, speed)

    def _target(self, target: float) -> Rejected | None:
        low, high = self._tension.minimum, self._tension.maximum
        if low <= target <= high:
            return None
        words = f"tension would be {target:.2f} N, allowed {low:.2f} to {high:.2f} N"
        return Rejected(Reason.TENSION_LIMIT, words)

    def _current(self, measured: Measurement) -> Rejected | None:
        if measured.tension <= (allowed := self._tension.limit):
            return None
        words = f"tension is {measured.tension:.2f} N already, allowed {allowed:.2f} N"
        return Rejected(Reason.TENSION_LIMIT, words)

    def _predicted(self, grasp: Grasp, step: float, measured: Measurement) -> Rejected | None:
        """Whether a step [m] would pull too hard, if the tissue goes on as it did so far."""
        slope = measured.tension / grasp.s if grasp.s > MIN_ROOM else 0.0
        predicted = measured.tension + slope * step
        return self._target(predicted) if predicted > self._tension.maximum else None

    def _room(self, grasp: Grasp) -> Rejected | None:
        if grasp.s + MIN_ROOM <= grasp.pull.length:
            return None
        return self._too_far(grasp.s + MIN_ROOM, grasp.pull.length)

    def _too_far(self, target: float, most: float) -> Rejected:
        words = f"pulled {target * 1e3:.1f} mm, allowed 0 to {most * 1e3:.1f} mm"
        return Rejected(Reason.DISPLACEMENT_LIMIT, words)


def _is_near(q: Vector, grasp: Grasp) -> bool:
    return float(np.abs(q - grasp.pull.evaluate(grasp.s).q).max()) <= NEAR


def _direction(command: Command) -> str:
    return "more" if command is Command.PULL_MORE else "less"


def _words(command: Command) -> str:
    return {
        Command.HEY_ROBOT: "ready",
        Command.STOP: 'stops and holds; say "hey robot" to go on',
        Command.TERMINATE: 'finishes braking, holds, and waits for "hey robot"',
    }[command]
