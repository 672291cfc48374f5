# SPDX-License-Identifier: BSD-3-Clause
"""Plans "look left" and its like: the tool turned as one about the trocar, or slid along its shaft.

Directions are those of the picture: the camera looks where the tool points, its right is the x axis
of tool_tip turned about the view by `image_roll`. A step sideways turns the whole tool about the
trocar, so that the tip goes that way in the picture and the depth stays; the wrist keeps its bend.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from rst_control.errors import Infeasible
from rst_control.kinematics.configuration import Configuration
from rst_control.planning.plan import Accepted, PhaseKind, Plan, Rejected
from rst_control.planning.planner import Planner, along
from rst_control.types import Command, Measurement, Reason, Vector, unit_vector

Array = NDArray[np.float64]

# Right and up in the picture, then in along the shaft.
WAYS: Final[dict[Command, tuple[int, int, int]]] = {
    Command.LOOK_LEFT: (-1, 0, 0),
    Command.LOOK_RIGHT: (1, 0, 0),
    Command.LOOK_UP: (0, 1, 0),
    Command.LOOK_DOWN: (0, -1, 0),
    Command.LOOK_UP_LEFT: (-1, 1, 0),
    Command.LOOK_UP_RIGHT: (1, 1, 0),
    Command.LOOK_DOWN_LEFT: (-1, -1, 0),
    Command.LOOK_DOWN_RIGHT: (1, -1, 0),
    Command.LOOK_CLOSER: (0, 0, 1),
    Command.LOOK_WIDER: (0, 0, -1),
}
MIN_ACROSS: Final = 0.3  # of a direction in the picture that is square to the way to the trocar


class TiltOutOfRange(Infeasible):
    """The shaft would lean too far over."""

    def __init__(self, tilt: float, allowed: float) -> None:
        super().__init__(
            f"shaft {np.degrees(tilt):.1f} deg from the patient's inward normal, "
            f"allowed {np.degrees(allowed):.1f} deg"
        )
        self.tilt, self.allowed = tilt, allowed


class CameraAskew(Infeasible):
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


class LookPlans:
    """Plans for one robot and scene.

    Args:
        planner: Its configuration holds steps and limits.
    """

    def __init__(self, planner: Planner) -> None:
        self._planner, self._config = planner, planner.config.controller.camera

    def __call__(self, command: Command, q: Vector, measured: Measurement) -> Accepted | Rejected:
        """Plan one step from q (9,) [rad].

        Raises:
            Infeasible: The step breaks a limit; the error says which.
        """
        if measured.gripped:
            words = f'tissue held, "{command.value}" needs empty jaws; release first'
            return Rejected(Reason.ALREADY_GRASPED, words)
        goal = self.goal(command, q)
        speed = self._planner.config.controller.speed.tip_speed
        paths = self._planner.route(q, goal)
        phases = tuple(along(self._planner, PhaseKind.LOOK, path, speed) for path in paths)
        return Accepted(Plan(command, self._words(command), phases))

    def goal(self, command: Command, q: Vector) -> Array:
        """Pose of tool_tip one step on from q (9,), base frame. Shape (4, 4).

        Raises:
            TiltOutOfRange: The shaft would lean too far over.
            CameraAskew: That way is nearly the way to the trocar.
        """
        here, trocar = Configuration(self._planner.model, q), self._planner.trocar
        goal, shaft = here.T_base_tip, here.T_base_shaft[:3, 2]
        right, up, inward = WAYS[command]
        if inward:
            goal[:3, 3] += inward * self._config.depth * shaft
            return goal
        seen = picture(goal, self._config.image_roll)
        way = unit_vector(right * seen.right + up * seen.up)
        arm = unit_vector(goal[:3, 3] - trocar)
        across = np.cross(arm, way)
        if (share := float(np.linalg.norm(across))) < MIN_ACROSS:
            raise CameraAskew(share)
        turn = _rotation(across / share, self._config.angle)
        self._require_tilt(turn @ shaft)
        goal[:3, 3] = trocar + turn @ (goal[:3, 3] - trocar)
        goal[:3, :3] = turn @ goal[:3, :3]
        return goal

    def _require_tilt(self, shaft: Vector) -> None:
        inward = -self._planner.patient.outward
        tilt = float(np.arccos(np.clip(shaft @ inward, -1.0, 1.0)))
        if tilt > self._config.max_tilt:
            raise TiltOutOfRange(tilt, self._config.max_tilt)

    def _words(self, command: Command) -> str:
        if WAYS[command][2]:
            way = "in" if WAYS[command][2] > 0 else "out"
            return f"moves {way} by {self._config.depth * 1e3:.0f} mm"
        _, _, where = command.value.partition(" ")
        return f"looks {where} by {np.degrees(self._config.angle):.1f} deg"


def _rotation(axis: Vector, angle: float) -> Array:
    """Rotation matrix (3, 3) about a unit axis (3,) (Rodrigues 1840)."""
    x, y, z = axis
    K = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + np.sin(angle) * K + (1.0 - np.cos(angle)) * (K @ K)
