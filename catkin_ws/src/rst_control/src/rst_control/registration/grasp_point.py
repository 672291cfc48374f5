# SPDX-License-Identifier: BSD-3-Clause
"""Setting where "tense" takes the tissue: only at rest, and only where it can be taken and pulled.

A person or a tracker names the point, and the way of the pull where that changes too. Or the tip
shows it: `GraspHere`.

Nothing moves by it. The whole way to the point, the pull and the way back are planned from where
the robot stands, and "tense" plans them once more.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import ClassVar

import numpy as np

from rst_control.commands.request import Accepted, Request, Situation
from rst_control.commands.spec import Role
from rst_control.commands.tense import choose_grasp
from rst_control.commands.verifier import reason_of
from rst_control.config import SceneConfig
from rst_control.errors import Infeasible
from rst_control.execution.event_log import EventKind
from rst_control.execution.setting_plan import SettingPlan
from rst_control.execution.snapshot import ControllerSnapshot
from rst_control.kinematics.configuration import planning_joints
from rst_control.registration.registrar import ContextRegistrar, position_words, ready
from rst_control.registration.trocar_context import Origin, TrocarContext
from rst_control.tissue.sheet import free_sides, rest_points
from rst_control.types import Cause, Reason, Rejected, Vector, unit_vector

POINT, POINT_AND_PULL = 3, 6  # numbers that a grasp is given by
MIN_PULL = 1e-6  # of the length of a direction


class GraspPointRegistrar(ContextRegistrar):
    """Sets the grasp point, with all that depends on it, in one tick of the control loop.

    A place is a point, base frame, [m], shape (3,), or a point and the way of the pull, shape (6,).
    """

    COMMAND: ClassVar[str] = "set_grasp_point"
    SET: ClassVar[EventKind] = "grasp_set"
    REFUSED: ClassVar[EventKind] = "grasp_refused"

    def _place(self, context: TrocarContext) -> Vector:
        return np.array(context.config.scene.grasp_point)

    def _other(self, context: TrocarContext) -> tuple[float, ...]:
        return context.config.scene.trocar

    def _note(self, origin: Origin) -> None:
        self._present.grasp_origin = origin

    def here(self, view: ControllerSnapshot) -> TrocarContext | Cause:
        """The present context with the tip's place as the grasp point, or why there is none."""
        measured = ready(self._present.current, view)
        if isinstance(measured, Cause):
            return measured
        return self._make(self._present.tip(measured.position).tolist(), view)

    def view(self) -> ControllerSnapshot:
        """The executor as it is now; any thread may ask."""
        return self._executor.snapshot

    def _make(self, place: Sequence[float], view: ControllerSnapshot) -> TrocarContext | Cause:
        present = self._present.current
        measured = ready(present, view)  # so that no motion is planned from a robot that moves
        if isinstance(measured, Cause):
            return measured
        numbers = [float(value) for value in place]
        point, pull = numbers[:POINT], numbers[POINT:POINT_AND_PULL]
        refusal = off_tissue(present.config.scene, point) or no_way(pull)
        if refusal is not None:
            return refusal
        context = present.with_grasp_point(point, pull)
        try:
            choose_grasp(context.planner, planning_joints(measured.position)[0])
        except Infeasible as error:
            return Cause(reason_of(error), f"the tissue cannot be taken there: {error}")
        return context

    def _decide(self, context: TrocarContext, view: ControllerSnapshot) -> Cause | str:
        measured = ready(context, view)
        if isinstance(measured, Cause):
            return measured
        words = f"grasp point {position_words(self._place(context))}"
        pull = context.config.scene.pull_direction
        if not pull:
            return words
        x, y, z = unit_vector(pull)
        return f"{words}, pulled along ({x:.3f}, {y:.3f}, {z:.3f})"


class GraspHere:
    """Verification of "grasp here", the tip's present place; all else is left to another.

    Args:
        verify: Decides everything else.
        registrar: Sets the grasp point.
    """

    def __init__(
        self,
        verify: Callable[[Request, Situation], Accepted | Rejected],
        registrar: GraspPointRegistrar,
    ) -> None:
        self._verify, self._registrar = verify, registrar

    def __call__(self, request: Request, situation: Situation) -> Accepted | Rejected:
        """Decide; see the class."""
        decision = self._verify(request, situation)
        if isinstance(decision, Rejected) or request.command.role is not Role.SET_UP:
            return decision
        context = self._registrar.here(self._registrar.view())
        if isinstance(context, Cause):
            return Rejected.by(context)
        made, place = context, position_words(np.array(context.config.scene.grasp_point))
        words = f"takes the tissue at {place} from now on"
        return Accepted(
            SettingPlan(
                request.command,
                words,
                change=lambda now, caller: self._registrar.activate(made, now, caller),
            )
        )


def no_way(pull: Sequence[float]) -> Cause | None:
    """Why a way of the pull (3,) is none; None: it is one, or () was given."""
    if not pull or (all(map(math.isfinite, pull)) and math.hypot(*pull) > MIN_PULL):
        return None
    return Cause(Reason.UNREACHABLE, f"pull direction {list(pull)}, allowed: finite and not zero")


def off_tissue(scene: SceneConfig, place: Sequence[float]) -> Cause | None:
    """Why jaws that come over a free side do not take the sheet at a point; None: they do.

    Args:
        scene: The sheet at rest, the jaws' clearance and how far from a node they still take it.
        place: Base frame, [m]. Shape (3,).
    """
    point = np.array(place, dtype=float)
    if not all(map(math.isfinite, point)):
        return Cause(Reason.UNREACHABLE, f"coordinates {point.tolist()} m, allowed: finite numbers")
    nearest = float(np.linalg.norm(rest_points(scene.tissue) - point, axis=1).min())
    if nearest > (allowed := scene.tissue.grasp_radius):
        words = f"{nearest * 1e3:.1f} mm from a node of the tissue, allowed {allowed * 1e3:.1f} mm"
        return Cause(Reason.NO_GRASP, words)
    sides = free_sides(scene.tissue)
    depth = min((float((edge - point) @ outward) for edge, outward in sides), default=math.inf)
    if depth > (allowed := scene.clearance):
        words = f"{depth * 1e3:.1f} mm inside the nearest free edge, allowed {allowed * 1e3:.1f} mm"
        return Cause(Reason.NO_GRASP, words)
    return None
