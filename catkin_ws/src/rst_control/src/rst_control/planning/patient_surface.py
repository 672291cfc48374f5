# SPDX-License-Identifier: BSD-3-Clause
"""The patient's surface: a plane through the trocar, outside of which arm and tool belong.

Only the tool may pass it, and only through the trocar. So at any moment either the whole robot is
outside by a margin, or the shaft has to be in the trocar. There is no third case, in which neither
would be checked.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite, nan
from typing import Any, Final

import numpy as np

from rst_control.config import MotionConfig
from rst_control.kernels import kernel
from rst_control.kinematics import forward as kin
from rst_control.kinematics.rcm import rcm_offset
from rst_control.kinematics.robot_model import RobotModel
from rst_control.planning.collision import CollisionModel, Plane
from rst_control.types import Vector, frozen_array, unit_vector

SURFACE: Final = "patient's surface"
WATCHED_SHARE: Final = 0.5  # of the planned margin, below which the shaft has to be in the trocar


@dataclass(frozen=True, slots=True)
class TrocarPose:
    """Where tool and arm are, as seen from the trocar."""

    error: float  # [m] distance of the shaft's line from the trocar
    insertion: float  # [m] of the tip inside the trocar; negative: outside
    wrist: float  # [m] of the wrist inside the trocar, along the shaft; negative: before it
    height: float  # [m] of the lowest part that can move above the patient's surface
    is_outside: bool  # all that can move is outside by a margin, so no shaft is in the trocar

    @property
    def rcm_error(self) -> float:
        """What counts as RCM error [m]: the shaft's, or none while nothing is in the trocar."""
        return 0.0 if self.is_outside else self.error


NOWHERE: Final = TrocarPose(nan, nan, nan, nan, is_outside=False)  # nothing was measured yet


class Patient:
    """Knows the surface, and measures against it. It never changes.

    Args:
        model: The robot.
        config: Scene, with trocar and surface, and the shapes of the robot.
    """

    def __init__(self, model: RobotModel, config: MotionConfig) -> None:
        scene = config.scene
        normal = unit_vector(scene.outward)
        self._chain, self._shaft = model.chain, model.shaft_length
        self.outward = frozen_array(normal, 3)  # base frame
        self._trocar = frozen_array(scene.trocar, 3)
        self._watched = WATCHED_SHARE * scene.surface_margin

        def kept_off(clearance: float, *exempt: str) -> CollisionModel:
            offset = float(normal @ self._trocar)
            surface = Plane(SURFACE, normal.tolist(), offset, clearance, (*model.standing, *exempt))
            return CollisionModel(config.collision, model, (surface,))

        self.outside = kept_off(scene.surface_margin)  # wholly outside
        self.passing = kept_off(scene.surface_margin, *model.insertable)  # through the trocar
        links = [body.link for body in config.collision.bodies]
        moving = [k for k, link in enumerate(links) if link not in model.standing]
        shapes = self.outside.shapes
        self._capsules, self._frames = shapes.capsules[moving], shapes.frames[moving]
        tool = [k for k, link in enumerate(links) if link in model.insertable]
        before_tip = _before_tip(self._chain, shapes.capsules[tool], shapes.frames[tool])
        self.min_standoff = scene.surface_margin + before_tip  # [m] that leaves the margin
        self.sweep = model.wrist_length + self.min_standoff  # [m] of pitch and yaw

    def wrist_height(self, q: Vector) -> float:
        """Height of the tool's wrist above the surface at q (9,) [rad], whatever the tool's [m]."""
        frames = np.empty((12, 3, 4))
        kin.forward(self._chain, np.array(q), frames)
        shaft = frames[kin.SHAFT]
        wrist = shaft[:, 3] + self._shaft * shaft[:, 2]
        return float(self.outward @ (wrist - self._trocar))

    def trocar_pose(self, q: Vector) -> TrocarPose:
        """Where tool and arm are at q (9,) [rad]."""
        error, along, tip, height, tip_height = _measure(
            self._chain, np.array(q), self._trocar, self.outward, self._capsules, self._frames
        )
        # The least of heights passes over what is no number; error and tip depend on every joint.
        is_outside = height >= self._watched and isfinite(error + tip)
        # Outside, a tool that points elsewhere may have its tip beyond the trocar along its shaft.
        insertion = min(tip, -tip_height) if tip_height > 0.0 else tip
        return TrocarPose(error, insertion, self._shaft - along, height, is_outside)


def _before_tip(chain: Any, capsules: Any, rows: Any) -> float:
    """How far the tool's capsules reach beyond the tip along the shaft [m]: with the tool straight.

    An upright shaft leaves the most room, so a tip nearer to the surface than that never keeps off.
    """
    frames = np.empty((12, 3, 4))
    kin.forward(chain, np.zeros(9), frames)
    shaft, tip = frames[kin.SHAFT, :, 2], frames[kin.TIP, :, 3]
    furthest = -np.inf
    for body, row in zip(capsules, rows, strict=True):
        for end in (body[:3], body[3:6]):
            place = frames[row, :, 3] + frames[row, :, :3] @ end
            furthest = max(furthest, float(shaft @ (place - tip)) + float(body[6]))
    return furthest


@kernel
def _measure(
    chain: Any, q: Any, trocar: Any, normal: Any, capsules: Any, rows: Any
) -> tuple[float, float, float, float, float]:
    """Lateral error, shaft up to the trocar, tip beyond it, lowest height, tip's height [m]."""
    frames = np.empty((12, 3, 4))
    kin.forward(chain, q, frames)
    x, y, along = rcm_offset(frames, trocar)
    beyond, tip_height = 0.0, 0.0
    for i in range(3):
        offset = frames[kin.TIP, i, 3] - trocar[i]
        beyond += offset * frames[kin.SHAFT, i, 2]
        tip_height += offset * normal[i]
    lowest = np.inf
    for n in range(len(capsules)):
        frame, body = frames[rows[n]], capsules[n]
        for end in range(0, 6, 3):
            above = -body[6]
            for i in range(3):
                place = frame[i, 3] - trocar[i]
                for j in range(3):
                    place += frame[i, j] * body[end + j]
                above += place * normal[i]
            lowest = min(lowest, above)
    return np.sqrt(x * x + y * y), along, beyond, lowest, tip_height
