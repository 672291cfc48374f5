# SPDX-License-Identifier: BSD-3-Clause
"""Plans the camera steps: the tool turned as one about the trocar, or slid along its shaft.

Directions are those of the picture: the camera looks where the tool points, its right is the x axis
of tool_tip turned about the view by `image_roll`. A step sideways turns the whole tool about the
trocar, so that the tip goes that way in the picture and the depth stays; the wrist keeps its bend.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from rst_control.commands.request import Accepted, PlanningContext
from rst_control.commands.spec import CommandSpec, LimitOfCommand, Load, TissueNeeded
from rst_control.config.camera import CameraStepConfig
from rst_control.kinematics.rotations import turned
from rst_control.planning.plan import PhaseKind
from rst_control.types import Reason, Vector, unit_vector

if TYPE_CHECKING:
    from rst_control.planning.planner import Planner

Array = NDArray[np.float64]

# Right and up in the picture, then in along the shaft.
STEPS: Final[dict[str, tuple[int, int, int]]] = {
    "look left": (-1, 0, 0),
    "look right": (1, 0, 0),
    "look up": (0, 1, 0),
    "look down": (0, -1, 0),
    "look up left": (-1, 1, 0),
    "look up right": (1, 1, 0),
    "look down left": (-1, -1, 0),
    "look down right": (1, -1, 0),
    "look closer": (0, 0, 1),
    "look wider": (0, 0, -1),
}
MIN_ACROSS: Final = 0.3  # of a direction in the picture that is square to the way to the trocar


class TiltOutOfRange(LimitOfCommand):
    """The shaft would lean too far over, and further than it does."""

    reason = Reason.TILT_LIMIT

    def __init__(self, tilt: float, allowed: float) -> None:
        super().__init__(
            f"shaft {np.degrees(tilt):.1f} deg from the patient's inward normal, "
            f"allowed {np.degrees(allowed):.1f} deg"
        )
        self.tilt, self.allowed = tilt, allowed


class CameraAskew(LimitOfCommand):
    """The tool is bent so far that a turn about the trocar hardly moves the picture that way."""

    def __init__(self, share: float) -> None:
        super().__init__(
            f"a turn about the trocar moves the picture that way by {share:.2f} of its length, "
            f"allowed {MIN_ACROSS:.2f} and more; the tool is bent too far"
        )
        self.share = share


@dataclass(frozen=True, eq=False)
class Picture:
    """Directions of the camera's picture, base frame, each of length 1 and shape (3,)."""

    right: Vector
    up: Vector
    forward: Vector


def picture(T_base_tip: Array, roll: float) -> Picture:
    """What the camera on a tool has at its right, above and before it.

    Args:
        T_base_tip: Pose of tool_tip, which points along its negative y axis. Shape (4, 4).
        roll: From tool_tip's x axis to the picture's right, clockwise as the camera sees [rad].
    """
    x, y, z = T_base_tip[:3, 0], T_base_tip[:3, 1], T_base_tip[:3, 2]
    right, down = np.cos(roll) * x + np.sin(roll) * z, np.cos(roll) * z - np.sin(roll) * x
    return Picture(right, -down, -y)


def plan(context: PlanningContext) -> Accepted:
    """Plan one step.

    Raises:
        Infeasible: The step breaks a limit; the error says which.
    """
    config, phrase = context.config, context.request.command.phrase
    goal = step_goal(context.planner, STEPS[phrase], context.q)
    paths = context.planner.route(context.q, goal)
    speed = config.speed.tip_speed
    phases = [context.along(PhaseKind.CAMERA_STEP, path, speed) for path in paths]
    return context.accept(_words(phrase, config.camera), phases)


CAMERA_STEPS: Final = tuple(
    CommandSpec(
        phrase,
        f"{'slides' if inward else 'turns'} the camera one step: {phrase.removeprefix('look ')}",
        load=Load.LOADS,
        tissue=TissueNeeded.NONE,
        phases=(PhaseKind.CAMERA_STEP,),
        plan=plan,
    )
    for phrase, (_, _, inward) in STEPS.items()
)


def step_goal(planner: Planner, step: tuple[int, int, int], q: Vector) -> Array:
    """Pose of tool_tip one step on from q (9,), base frame. Shape (4, 4).

    Args:
        planner: Its configuration holds steps and limits.
        step: Right and up in the picture, then in along the shaft; -1, 0 or 1.
        q: Joints [rad]. Shape (9,).

    Raises:
        TiltOutOfRange: The shaft would lean too far over, and further than it does.
        CameraAskew: That way is nearly the way to the trocar.
    """
    from rst_control.kinematics.configuration import Configuration

    here, trocar, config = Configuration(planner.model, q), planner.trocar, _settings(planner)
    goal, shaft = here.T_base_tip, here.T_base_shaft[:3, 2]
    right, up, inward = step
    if inward:
        goal[:3, 3] += inward * config.depth * shaft
        return goal
    shown = picture(goal, config.image_roll)
    way = unit_vector(right * shown.right + up * shown.up)
    arm = unit_vector(goal[:3, 3] - trocar)
    across = np.cross(arm, way)
    if (share := float(np.linalg.norm(across))) < MIN_ACROSS:
        raise CameraAskew(share)
    turn = turned(config.angle / share * across)
    _require_tilt(planner, shaft, turn @ shaft)
    goal[:3, 3] = trocar + turn @ (goal[:3, 3] - trocar)
    goal[:3, :3] = turn @ goal[:3, :3]
    return goal


def _settings(planner: Planner) -> CameraStepConfig:
    return planner.config.controller.camera


def _require_tilt(planner: Planner, before: Vector, after: Vector) -> None:
    """Refuse a shaft that leans too far, unless the step brings it nearer to upright."""
    maximum = _settings(planner).max_tilt
    tilt = _tilt(planner, after)
    if tilt > maximum and tilt >= _tilt(planner, before):
        raise TiltOutOfRange(tilt, maximum)


def _tilt(planner: Planner, shaft: Vector) -> float:
    """Angle of a shaft from the patient's inward normal [rad]."""
    return float(np.arccos(np.clip(shaft @ -planner.patient.outward, -1.0, 1.0)))


def _words(phrase: str, config: CameraStepConfig) -> str:
    if inward := STEPS[phrase][2]:
        return f"moves {'in' if inward > 0 else 'out'} by {config.depth * 1e3:.0f} mm"
    where = phrase.removeprefix("look ")
    return f"looks {where} by {np.degrees(config.angle):.1f} deg"
