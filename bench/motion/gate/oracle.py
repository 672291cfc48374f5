# SPDX-License-Identifier: BSD-3-Clause
"""An independent judge of plans and refusals: KDL, PyBullet, and the closed form of the wrist.

The tool's pose and the trocar fix the wrist: the shaft lies in the plane of the trocar and the
jaws' axis, so depth and pitch point follow without any solver.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise

import numpy as np
import PyKDL
from numpy.typing import NDArray

from bench.motion.bullet.bodies import BulletBodies
from bench.motion.gate.cases import Case
from rst_control.commands.request import Plan
from rst_control.config.collision import CollisionConfig
from rst_control.kinematics.configuration import planning_joints
from rst_control.kinematics.joint_limits import make_limits
from rst_control.kinematics.robot_model import load_robot
from rst_control.kinematics.rotations import turned
from rst_control.planning.collision_kernels import RESOLUTION
from rst_control.planning.plan import Phase
from rst_control.tissue.grasp_candidates import grasp_candidates
from rst_control.types import Reason, unit_vector
from support.kdl_chain import Kdl

Array = NDArray[np.float64]
JAW, WRIST = 0.015, 0.0115  # [m] from the tip to the jaws' axis, from there to the pitch axis
PATH_SAMPLES = 25  # places on each path
STRIDE = 0.0005  # [m] of the follower's steps
TINY = 1e-9
BODY_TINY = 1e-6  # [m] to which PyBullet knows distances
RCM_WORST = 1e-6  # [m]
BODY_SAMPLES = 9  # places on each path where PyBullet measures distances
BODY_STRIDE = 4  # steps of the follower from one such measurement to the next
BODIES_CLOSE = 5e-4  # [m] that a distance may be missed by between them
SINGULAR_CLOSE = 1.005  # [-] the same for manipulability
RADIAN = 0.1  # [m] that a radian of the tool counts as in the manipulability
CLOSE = 1e-4  # [m] that a limit may be missed by in the sampling of the judge


class GateJudge:
    """Knows the robot by KDL and PyBullet only."""

    def __init__(self) -> None:
        model = load_robot()
        self._arm, self._tip = Kdl(model, "interface_link"), Kdl(model, "tool_tip")
        self._bodies: tuple[CollisionConfig, BulletBodies] | None = None

    # Refusals.

    def is_true(self, case: Case, reason: Reason) -> bool:
        """Whether a refusal for a geometric reason is true."""
        match reason:
            case Reason.WORKSPACE:
                return self._leaves_workspace(case)
            case Reason.INSERTION_DEPTH:
                return self._leaves_insertion(case)
            case Reason.RCM_TOLERANCE:
                return self._is_adrift(case)
            case Reason.UNREACHABLE:  # the tracker loses its way at singular places, or just before
                return not self._can_follow(case) or self._comes_near_singular(case)
            case Reason.JOINT_LIMIT:
                return not self._can_follow(case)
            case Reason.COLLISION:
                return self._comes_too_near(case)
            case Reason.SINGULAR:
                return self._comes_near_singular(case)
        return False

    def _is_adrift(self, case: Case) -> bool:
        measured = case.situation.measurement
        allowed = case.config.rcm.measured_tolerance
        if measured is None:
            return False
        q = planning_joints(measured.position)[0]
        return self._trocar(q, np.array(case.config.scene.trocar))[0] > allowed

    def _leaves_workspace(self, case: Case) -> bool:
        scene = case.config.scene
        away = [np.linalg.norm(T[:3, 3] - scene.workspace_centre) for T in self._waypoints(case)]
        return bool(max(away) > scene.workspace_radius)

    def _leaves_insertion(self, case: Case) -> bool:
        low, high = case.config.rcm.insertion
        trocar = np.array(case.config.scene.trocar)
        depths = [_depth(T, trocar) for T in self._way(case, 2.0 * STRIDE)]
        return min(depths) < low + CLOSE or max(depths) > high - CLOSE

    def _can_follow(self, case: Case) -> bool:
        """Whether joints that keep their limits can be led along the whole way, step by step."""
        limits = make_limits(case.config.limits, case.config.controller.jaws.open)
        return all(
            missing <= 1e-4 and limits.violation(q) is None for q, missing in self._led(case, 0.02)
        )

    def _comes_too_near(self, case: Case) -> bool:
        """Whether two bodies come nearer than allowed where the elbow does not swing."""
        allowed = case.config.collision.clearance + BODIES_CLOSE
        ways = enumerate(self._led(case, 0.0))
        return any(
            self._min_distance(case, q) < allowed for n, (q, _) in ways if n % BODY_STRIDE == 0
        )

    def _comes_near_singular(self, case: Case) -> bool:
        """Whether the manipulability falls below its limit where the elbow does not swing."""
        allowed = case.config.limits.min_manipulability * SINGULAR_CLOSE
        return any(self._manipulability(case, q) < allowed for q, _ in self._led(case, 0.0))

    def _min_distance(self, case: Case, q: Array) -> float:
        config = replace(case.config.collision, clearance=0.0)
        if self._bodies is None or self._bodies[0] != config:
            if self._bodies is not None:
                self._bodies[1].close()
            self._bodies = config, BulletBodies(config)
        return self._bodies[1].nearest(q)[0]

    def _manipulability(self, case: Case, q: Array) -> float:
        _, J = self._constraints(q, np.eye(4), np.array(case.config.scene.trocar))
        J[5:] *= RADIAN
        return float(np.prod(np.linalg.svd(J, compute_uv=False)))

    def _led(self, case: Case, sway: float) -> Iterator[tuple[Array, float]]:
        """Joints (9,) step by step along the whole way, and what is missing to the pose.

        Args:
            case: With start and way.
            sway: How fast the elbow swings away from the joint limits; 0: not at all.
        """
        limits = make_limits(case.config.limits, case.config.controller.jaws.open)
        trocar = np.array(case.config.scene.trocar)
        q = self._start(case)
        middle, half = 0.5 * (limits.lower + limits.upper), 0.5 * (limits.upper - limits.lower)
        for T in self._way(case, STRIDE):
            for _ in range(3):
                missing, J = self._constraints(q, T, trocar)
                inverse = np.linalg.pinv(J, rcond=1e-6)
                x = (q - middle) / half
                away = -sway * x**5 / half
                q = q + inverse @ missing + away - inverse @ (J @ away)
            yield q, float(np.abs(self._constraints(q, T, trocar)[0]).max())

    def _constraints(self, q: Array, T: Array, trocar: Array) -> tuple[Array, Array]:
        """What is missing to pose and trocar (8,), and how joints change it (8, 9)."""
        shaft, J_shaft = self._arm.frame(q[:7]), self._arm.jacobian(q[:7])
        tip, J_tip = self._tip.frame(q), self._tip.jacobian(q)
        R, offset = shaft[:3, :3], trocar - shaft[:3, 3]
        J = np.zeros((8, 9))
        J[:2, :7] = (R.T @ (J_shaft[:3] + np.cross(J_shaft[3:], offset, axis=0)))[:2]
        J[2:] = J_tip
        turn = 0.5 * np.cross(tip[:3, :3].T, T[:3, :3].T).sum(axis=0)
        return np.concatenate([(R.T @ offset)[:2], T[:3, 3] - tip[:3, 3], turn]), J

    def _way(self, case: Case, stride: float) -> Iterator[Array]:
        """Poses along the straight way through all waypoints."""
        for a, b in pairwise(self._waypoints(case)):
            shift, turn = b[:3, 3] - a[:3, 3], _turn(a[:3, :3], b[:3, :3])
            length = max(float(np.linalg.norm(shift)), 0.03 * float(np.linalg.norm(turn)))
            for share in np.linspace(0.0, 1.0, int(length / stride) + 2):
                T = np.eye(4)
                T[:3, :3] = turned(share * turn) @ a[:3, :3]
                T[:3, 3] = a[:3, 3] + share * shift
                yield T

    def _waypoints(self, case: Case) -> tuple[Array, ...]:
        scene, start = case.config.scene, self._tip.frame(self._start(case))
        grasp = grasp_candidates(scene)[0].T_base_tip
        other = grasp.copy()
        other[:3, [0, 2]] *= -1.0
        turns = [np.linalg.norm(_turn(start[:3, :3], T[:3, :3])) for T in (grasp, other)]
        grasp = grasp if turns[0] <= turns[1] else other
        before, pulled = grasp.copy(), grasp.copy()
        before[:3, 3] -= scene.clearance * unit_vector(scene.approach_axis)
        pulled[:3, 3] += scene.max_displacement * unit_vector(scene.pull_direction)
        return start, before, grasp, pulled

    def _start(self, case: Case) -> Array:
        setpoint = case.situation.setpoint
        return np.zeros(9) if setpoint is None else planning_joints(setpoint)[0]

    # Plans.

    def objection(self, case: Case, plan: Plan) -> str:
        """What is wrong with an accepted plan; empty: nothing."""
        q = self._start(case)
        for phase in plan.phases:
            if phase.path is None:
                continue
            if np.abs(phase.path.evaluate(phase.start).q - q).max() > 2e-3:
                return f"{phase.kind.value} begins away from where the last one ends"
            wrong = self._wrong(case, phase)
            if wrong:
                return f"{phase.kind.value}: {wrong}"
            q = phase.path.evaluate(phase.target).q
        return ""

    def _wrong(self, case: Case, phase: Phase) -> str:
        config, path = case.config, phase.path
        if path is None:
            return ""
        limits = make_limits(config.limits, config.controller.jaws.open)
        trocar, centre = np.array(config.scene.trocar), np.array(config.scene.workspace_centre)
        middle, half = 0.5 * (limits.lower + limits.upper), 0.5 * (limits.upper - limits.lower)
        low, high = config.rcm.insertion
        for s in np.linspace(phase.start, phase.target, PATH_SAMPLES):
            q, dq, ddq = path.evaluate(float(s))
            error, depth = self._trocar(q, trocar)
            tip = self._tip.frame(q)[:3, 3]
            acceleration = np.abs(dq) * phase.acceleration + np.abs(ddq) * phase.speed**2
            checks = {
                "trocar": error <= RCM_WORST,
                "insertion": low - TINY <= depth <= high + TINY,
                "workspace": np.linalg.norm(tip - centre) <= config.scene.workspace_radius + TINY,
                "joint limit": bool((np.abs(q - middle) <= half + TINY).all()),
                "joint speed": bool((np.abs(dq) * phase.speed <= 1.001 * limits.velocity).all()),
                "joint acceleration": bool((acceleration <= 1.01 * limits.acceleration).all()),
            }
            for name, holds in checks.items():
                if not holds:
                    return f"{name} at {s * 1e3:.1f} mm"
        return self._wrong_posture(case, phase)

    def _wrong_posture(self, case: Case, phase: Phase) -> str:
        if phase.path is None:
            return ""
        clearance = case.config.collision.clearance - 0.5 * RESOLUTION
        manipulability = case.config.limits.min_manipulability / SINGULAR_CLOSE
        for s in np.linspace(phase.start, phase.target, BODY_SAMPLES):
            q = phase.path.evaluate(float(s)).q
            if self._min_distance(case, q) < clearance - BODY_TINY:
                return f"collision at {s * 1e3:.1f} mm"
            if self._manipulability(case, q) < manipulability:
                return f"near singular at {s * 1e3:.1f} mm"
        return ""

    def _trocar(self, q: Array, trocar: Array) -> tuple[float, float]:
        """Distance of the shaft from the trocar, and length of shaft inside it [m]."""
        shaft = self._arm.frame(q[:7])
        inside = shaft[:3, :3].T @ (trocar - shaft[:3, 3])
        return float(np.hypot(inside[0], inside[1])), 0.28 - float(inside[2])


def _depth(T: Array, trocar: Array) -> float:
    """Length of shaft inside the trocar for a pose of the tip, by the wrist's closed form [m]."""
    axis = T[:3, 2]  # of the jaws
    joint = T[:3, 3] + JAW * T[:3, 1]
    towards = trocar - joint
    towards = unit_vector(towards - axis * float(axis @ towards))
    return float(np.linalg.norm(trocar - joint - WRIST * towards))


def _turn(a: Array, b: Array) -> Array:
    """Rotation vector [rad], base frame, that turns a (3, 3) into b (3, 3)."""
    quaternion = PyKDL.Rotation(*(b @ a.T).ravel().tolist()).GetRot()
    return np.array([quaternion.x(), quaternion.y(), quaternion.z()])
