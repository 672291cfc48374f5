# SPDX-License-Identifier: BSD-3-Clause
"""Setting where "tense" takes the tissue: only at rest, and only where it can be taken and pulled.

Nothing moves by it. The whole way to the point, the pull and the way back are planned from where
the robot stands, and "tense" plans them once more.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import ClassVar

import numpy as np

from rst_control.commands.tense import choose_grasp
from rst_control.commands.verifier import reason_of
from rst_control.config import SceneConfig
from rst_control.errors import Infeasible
from rst_control.execution.event_log import EventKind
from rst_control.execution.snapshot import ControllerSnapshot
from rst_control.kinematics.configuration import planning_joints
from rst_control.registration.registrar import ContextRegistrar, position_words, ready
from rst_control.registration.trocar_context import TrocarContext
from rst_control.tissue.sheet import free_sides, rest_points
from rst_control.types import Cause, Reason, Vector


class GraspPointRegistrar(ContextRegistrar):
    """Sets the grasp point, with all that depends on it, in one tick of the control loop."""

    COMMAND: ClassVar[str] = "set_grasp_point"
    SET: ClassVar[EventKind] = "grasp_set"
    REFUSED: ClassVar[EventKind] = "grasp_refused"

    def _place(self, context: TrocarContext) -> Vector:
        return np.array(context.config.scene.grasp_point)

    def _other(self, context: TrocarContext) -> tuple[float, ...]:
        return context.config.scene.trocar

    def _make(self, place: Sequence[float], view: ControllerSnapshot) -> TrocarContext | Cause:
        present = self._present.current
        measured = ready(present, view)  # so that no motion is planned from a robot that moves
        if isinstance(measured, Cause):
            return measured
        refusal = off_tissue(present.config.scene, place)
        if refusal is not None:
            return refusal
        context = present.with_grasp_point(place)
        try:
            choose_grasp(context.planner, planning_joints(measured.position)[0])
        except Infeasible as error:
            return Cause(reason_of(error), f"the tissue cannot be taken there: {error}")
        return context

    def _decide(self, context: TrocarContext, view: ControllerSnapshot) -> Cause | str:
        measured = ready(context, view)
        if isinstance(measured, Cause):
            return measured
        return f"grasp point {position_words(self._place(context))}"


def off_tissue(scene: SceneConfig, place: Sequence[float]) -> Cause | None:
    """Why jaws that come over a free side do not take the sheet at a point; None: they do.

    Args:
        scene: The sheet at rest, the jaws' clearance and how far from a node they still take it.
        place: Base frame, [m]. Shape (3,).
    """
    point = np.array(place, dtype=float)
    if not all(map(math.isfinite, point)):
        return Cause(Reason.UNREACHABLE, "a coordinate is no finite number")
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
