# SPDX-License-Identifier: BSD-3-Clause
"""A trocar with all that depends on it, so that all of it changes at once or not at all."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from rst_control.commands.request import Accepted, Request, Situation
from rst_control.commands.verifier import Verifier
from rst_control.config import MotionConfig, SceneConfig
from rst_control.errors import RstError
from rst_control.kinematics import forward
from rst_control.kinematics.configuration import Configuration, planning_joints
from rst_control.kinematics.rcm import RcmState, rcm_state
from rst_control.kinematics.robot_model import RobotModel
from rst_control.planning.patient_surface import TrocarPose
from rst_control.planning.planner import Planner
from rst_control.types import Point, Rejected, Vector

SCENE: Final = "scene.yaml"  # source of what nobody has set yet


class TrocarOutOfReach(RstError):
    """No posture of the arm takes the shaft to the trocar."""

    def __init__(self, distance: float, reach: float) -> None:
        super().__init__(
            f"trocar {distance:.3f} m from base_link, allowed 0 to {reach:.3f} m, the arm's reach"
        )
        self.distance, self.reach = distance, reach


class TrocarContext:
    """One trocar, and the planning, verification and measurement that refer to it.

    It never changes. Another trocar is another context.

    Args:
        config: Settings; `scene.trocar` is the trocar.
        model: The robot.

    Raises:
        TrocarOutOfReach: No posture takes the shaft there.
    """

    def __init__(self, config: MotionConfig, model: RobotModel) -> None:
        _require_reach(model, config.scene.trocar)
        self.config, self.model = config, model
        self.planner = Planner(model, config)
        self.verify = Verifier(self.planner)
        self.trocar = self.planner.trocar

    def shaft(self, joints: Vector) -> RcmState:
        """Where the trocar is as seen from the shaft, for the robot's joints (10,) [rad]."""
        q, _ = planning_joints(joints)
        return rcm_state(Configuration(self.model, q), self.trocar)

    def with_trocar(self, trocar: Sequence[float]) -> TrocarContext:
        """The same context with another trocar, base frame, [m]. Shape (3,).

        Raises:
            TrocarOutOfReach: No posture takes the shaft there, or a value is not finite.
        """
        return self._with(replace(self.config.scene, trocar=_point(trocar)))

    def with_grasp_point(self, place: Sequence[float], pull: Sequence[float] = ()) -> TrocarContext:
        """The same context with another grasp point, and another way of the pull if it is given.

        Args:
            place: Base frame, [m]. Shape (3,).
            pull: Base frame, of any length. Shape (3,); (): as it is.
        """
        scene = replace(self.config.scene, grasp_point=_point(place))
        return self._with(replace(scene, pull_direction=tuple(pull)) if pull else scene)

    def _with(self, scene: SceneConfig) -> TrocarContext:
        return TrocarContext(replace(self.config, scene=scene), self.model)


@dataclass(frozen=True)
class Origin:
    """Who set a place, and when."""

    source: str  # SCENE, or the name of a node
    stamp: float  # [s] steady clock


class ActiveTrocarContext:
    """The active trocar and all computed from it.

    Only the control loop replaces it, between two ticks at rest. A caller that verifies a command
    notes the executor's serial number first. The number changes with the trocar, and the command
    is then verified again.

    Args:
        context: Active at the start, of the settings; its scene stays in `configured`.
        stamp: Time of the start [s].
    """

    def __init__(self, context: TrocarContext, stamp: float = 0.0) -> None:
        self.current, self.configured = context, context.config.scene
        self.trocar_origin = self.grasp_origin = Origin(SCENE, stamp)

    def verify(self, request: Request, situation: Situation) -> Accepted | Rejected:
        """Decide whether a command may run."""
        return self.current.verify(request, situation)

    def tip(self, joints: Vector) -> Vector:
        """Tool tip at robot joints (10,) [rad]: base frame, [m]. Shape (3,)."""
        return Configuration(self.current.model, planning_joints(joints)[0]).tip

    def trocar_pose(self, joints: Vector) -> TrocarPose:
        """Where tool and arm are towards trocar and patient for the robot's joints (10,) [rad]."""
        return self.current.planner.patient.trocar_pose(planning_joints(joints)[0])


def _point(values: Sequence[float]) -> Point:
    x, y, z = (float(value) for value in values)
    return x, y, z


def _require_reach(model: RobotModel, trocar: Sequence[float]) -> None:
    links = [*range(7), forward.SHAFT]
    reach = model.shaft_length + float(np.linalg.norm(model.chain[links, :, 3], axis=1).sum())
    distance = math.hypot(*trocar)
    if not distance <= reach:
        raise TrocarOutOfReach(distance, reach)
