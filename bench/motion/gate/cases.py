# SPDX-License-Identifier: BSD-3-Clause
"""Random commands and situations for the feasibility gate, each with what must come of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from bench.motion.gate.near_cases import (
    CROWDED,
    STRETCHED,
    near,
    with_clearance,
    with_manipulability,
    working_at,
)
from bench.motion.paths import random_paths
from rst_control.commands.parser import read_request
from rst_control.commands.request import Accepted, Situation
from rst_control.commands.verifier import Verifier
from rst_control.config import MotionConfig
from rst_control.errors import Infeasible
from rst_control.kinematics import manipulability
from rst_control.kinematics.configuration import Configuration, robot_joints
from rst_control.kinematics.rcm import rcm_state
from rst_control.kinematics.robot_model import load_robot
from rst_control.kinematics.rotations import turned
from rst_control.planning.collision import CollisionModel
from rst_control.planning.plan import Grasp
from rst_control.planning.planner import Planner
from rst_control.types import Cause, ControllerMode, Measurement, Reason, Rejected, State

Array = NDArray[np.float64]
NOW = 100.0  # [s]
MOTIONS = ("tense", "release", "pull more", "pull less")
NONSENSE = ("pull", "tens", "stop it", "don't pull more", "", "release the beds", "hey", "more")


@dataclass(frozen=True)
class Asked:
    """A command in words with its amounts."""

    words: str
    tension: float = 0.0  # [N]
    distance: float = 0.0  # [m]


@dataclass(frozen=True, eq=False)
class Case:
    """A command in a situation."""

    verify: Verifier
    config: MotionConfig
    request: Asked
    situation: Situation
    expected: Reason | None  # why it must be refused; None: see `is_feasible`
    is_feasible: bool  # it must be accepted; False without `expected`: the oracle decides

    def decide(self) -> Accepted | Rejected:
        """What the gate makes of it."""
        asked = self.request
        request = read_request(asked.words, asked.tension, asked.distance)
        return request if isinstance(request, Rejected) else self.verify(request, self.situation)


@dataclass(frozen=True, eq=False)
class GateScene:
    """A verifier with tissue that can be grasped, and a grasp."""

    config: MotionConfig
    verify: Verifier
    starts: list[Array]  # (9,) each, [rad]
    grasp: Grasp


class Cases:
    """Draws cases.

    Args:
        config: The usual settings.
        seed: Of all that is drawn.
    """

    def __init__(self, config: MotionConfig, seed: int) -> None:
        self._rng = np.random.default_rng(seed)
        self._config, self._model = config, load_robot()
        self._trocar = np.array(config.scene.trocar)
        usual = Planner(self._model, config)
        usual.warm_up()
        self._starts = [path.end for path, _ in random_paths(usual, 30, seed=50, spread=0.3)]
        self._scenes = [self._scene(config, usual)]
        while len(self._scenes) < 20:
            moved = self._moved(0.3, 0.15)
            try:
                self._scenes.append(self._scene(moved, Planner(self._model, moved)))
            except Infeasible:
                continue
        self._wrong: tuple[Callable[[], Case], ...] = (
            self._unknown, self._standby, self._halted, self._busy, self._absent, self._stale,
            self._faulted, self._restless, self._empty, self._grasped, self._tension,
            self._distance, self._adrift, self._too_near, self._too_stretched,
        )  # fmt: skip

    def feasible(self) -> Case:
        """A command that nothing speaks against."""
        scene = self._scenes[self._rng.integers(len(self._scenes))]
        words = ("tense", "pull more", "pull less", "release")[self._rng.integers(4)]
        if words == "tense":
            target = float(self._rng.uniform(0.3, 2.0))
            return self._case(scene, Asked(words, target), self._free(), None, True)
        s, now = self._rng.uniform(0.005, 0.02), self._rng.uniform(0.6, 1.4)
        step = float(self._rng.uniform(0.05, 0.45)) if words != "release" else 0.0
        held = self._held(scene, float(s), float(now))
        return self._case(scene, Asked(words, step), held, None, True)

    def infeasible(self) -> Case:
        """A command with one thing wrong."""
        return self._wrong[self._rng.integers(len(self._wrong))]()

    def geometric(self) -> Case:
        """Tense on tissue anywhere about the workspace, with limits that may be narrow."""
        config = self._moved(1.3, 0.5)
        rng, limits = self._rng, config.limits
        if rng.uniform() < 0.4:
            low = float(rng.uniform(0.05, 0.14))
            insertion = (low, low + float(rng.uniform(0.02, 0.10)))
            config = replace(config, rcm=replace(config.rcm, insertion=insertion))
        if rng.uniform() < 0.4:
            home, room = np.array(config.scene.home), rng.uniform(0.05, 0.6, 7)
            lower = np.maximum(limits.arm_lower, home[:7] - room)
            upper = np.minimum(limits.arm_upper, home[:7] + room)
            limits = replace(limits, arm_lower=tuple(lower), arm_upper=tuple(upper))
            config = replace(config, limits=limits)
        return self._at_home(config)

    def near(self) -> Case:
        """Tense with the tool near the arm, or the arm near a singularity."""
        postures = (CROWDED, STRETCHED)[self._rng.integers(2)]
        q = near(postures, self._rng)
        return self._at_home(working_at(self._config, self._model, q, self._rng))

    # One thing wrong each.

    def _unknown(self) -> Case:
        words = NONSENSE[self._rng.integers(len(NONSENSE))]
        return self._usual(Asked(words), Reason.UNKNOWN_COMMAND)

    def _standby(self) -> Case:
        return self._usual(self._motion(), Reason.WRONG_MODE, state=State.STANDBY)

    def _halted(self) -> Case:
        cause = Cause(Reason.STOP_COMMAND, "stopped by a person")
        halted = {"state": State.HALTED, "cause": cause}
        return self._usual(self._motion(), Reason.HALTED, **halted)

    def _busy(self) -> Case:
        words = ("tense", "release")[self._rng.integers(2)]
        return self._usual(Asked(words), Reason.BUSY, state=State.MOVING)

    def _absent(self) -> Case:
        return self._usual(self._motion(), Reason.NOT_CONNECTED, connected=False)

    def _stale(self) -> Case:
        age = float(self._rng.uniform(0.021, 2.0))
        return self._usual(self._motion(), Reason.STALE, stamp=NOW - age)

    def _faulted(self) -> Case:
        return self._usual(self._motion(), Reason.FAULTED, fault="joint_3 is blocked")

    def _restless(self) -> Case:
        """Braking, after which it is active or in standby."""
        return self._usual(self._motion(), Reason.NOT_AT_REST, state=State.STOPPING)

    def _empty(self) -> Case:
        words = MOTIONS[self._rng.integers(1, 4)]
        return self._usual(Asked(words), Reason.NOTHING_GRASPED)

    def _grasped(self) -> Case:
        scene = self._scenes[self._rng.integers(len(self._scenes))]
        held = self._held(scene, 0.01, 1.0)
        return self._case(scene, Asked("tense"), held, Reason.ALREADY_GRASPED, False)

    def _tension(self) -> Case:
        """A target over or under the band, by "tense" or by a step."""
        rng, tension = self._rng, self._config.controller.tension
        low, high = tension.minimum, tension.maximum
        if rng.uniform() < 0.5:
            target = rng.uniform(0.01, low - 1e-3) if rng.uniform() < 0.5 else high + rng.uniform()
            return self._usual(Asked("tense", float(target + 1e-6)), Reason.TENSION_LIMIT)
        scene = self._scenes[rng.integers(len(self._scenes))]
        now = float(rng.uniform(0.3, 1.8))
        words = MOTIONS[rng.integers(2, 4)]
        room = high - now if words == "pull more" else now - low
        request = Asked(words, room + float(rng.uniform(0.001, 0.5)))
        held = self._held(scene, 0.01, now)
        return self._case(scene, request, held, Reason.TENSION_LIMIT, False)

    def _distance(self) -> Case:
        rng, length = self._rng, self._config.scene.max_displacement
        if rng.uniform() < 0.3:
            request = Asked("tense", 1.0, length + float(rng.uniform(1e-4, 0.05)))
            return self._usual(request, Reason.DISPLACEMENT_LIMIT)
        scene = self._scenes[rng.integers(len(self._scenes))]
        s, words = float(rng.uniform(0.003, 0.027)), MOTIONS[rng.integers(2, 4)]
        room = length - s if words == "pull more" else s
        request = Asked(words, 0.0, room + float(rng.uniform(1e-4, 0.02)))
        held = self._held(scene, s, 0.3)
        return self._case(scene, request, held, Reason.DISPLACEMENT_LIMIT, False)

    def _adrift(self) -> Case:
        """Shaft off the trocar by more than allowed, by turning one joint."""
        off = 0.0
        while off <= self._config.rcm.measured_tolerance + 1e-6:
            q = self._start().copy()
            turn = float(self._rng.uniform(0.003, 0.1)) * float(self._rng.choice([-1, 1]))
            q[self._rng.integers(7)] += turn
            off = rcm_state(Configuration(self._model, q), self._trocar).error
        scene, situation = self._scenes[0], self._situation(robot_joints(q, 0.0))
        return self._case(scene, Asked("tense"), situation, Reason.RCM_TOLERANCE, False)

    def _too_near(self) -> Case:
        """Two bodies nearer to each other at the start than allowed."""
        q = near(CROWDED, self._rng)
        found = CollisionModel(self._config.collision, self._model).clearance(q).distance
        more = float(self._rng.uniform(1e-4, 0.01))
        config = with_clearance(self._config, max(found, 0.0) + more)
        config = working_at(config, self._model, q, self._rng)
        return self._at_home(config, Reason.COLLISION)

    def _too_stretched(self) -> Case:
        """Nearer to a singularity at the start than allowed."""
        q = near(CROWDED, self._rng)
        config = working_at(self._config, self._model, q, self._rng)
        trocar = np.array(config.scene.trocar)
        found = manipulability.measure(self._model.chain, q, trocar)
        config = with_manipulability(config, found * float(self._rng.uniform(1.001, 1.5)))
        return self._at_home(with_clearance(config, 0.0), Reason.SINGULAR)

    # Parts.

    def _at_home(self, config: MotionConfig, expected: Reason | None = None) -> Case:
        """Tense from the home of a scene of its own."""
        verify = Verifier(Planner(self._model, config))
        free = self._situation(robot_joints(np.array(config.scene.home), 0.0))
        return Case(verify, config, Asked("tense", 1.0), free, expected, False)

    def _moved(self, reach: float, tilt: float) -> MotionConfig:
        """Settings with the tissue elsewhere and turned.

        Args:
            reach: Share of the workspace's radius, from its centre.
            tilt: About each axis, at most [rad].
        """
        rng, scene = self._rng, self._config.scene
        direction = rng.normal(size=3)
        away = reach * scene.workspace_radius * rng.uniform() ** (1.0 / 3.0)
        R = turned(rng.uniform(-tilt, tilt, 3))
        grasp = scene.workspace_centre + away * direction / np.linalg.norm(direction)
        along, across = R @ scene.tissue.along, R @ scene.tissue.across
        tissue = replace(
            scene.tissue,
            centre=tuple(grasp - 0.5 * scene.tissue.size[0] * along),
            along=tuple(along),
            across=tuple(across),
            reference_point=tuple(grasp),
            reference_pull=tuple(0.01 * along),
        )
        scene = replace(
            scene,
            grasp_point=tuple(grasp),
            approach_axis=tuple(R @ scene.approach_axis),
            jaw_axis=tuple(R @ scene.jaw_axis),
            pull_direction=tuple(R @ scene.pull_direction),
            tissue=tissue,
        )
        return replace(self._config, scene=scene)

    def _scene(self, config: MotionConfig, planner: Planner) -> GateScene:
        at_grasp = planner.reach(np.array(config.scene.home))[-1].end
        grasp = Grasp(planner.pull(at_grasp), planner.retreat(at_grasp))
        return GateScene(config, Verifier(planner), self._starts, grasp)

    def _start(self) -> Array:
        return self._starts[self._rng.integers(len(self._starts))]

    def _motion(self) -> Asked:
        return Asked(MOTIONS[self._rng.integers(4)])

    def _free(self, **changes: object) -> Situation:
        return self._situation(robot_joints(np.array(self._config.scene.home), 0.0), **changes)

    def _held(self, scene: GateScene, s: float, tension: float) -> Situation:
        joints = robot_joints(scene.grasp.pull.evaluate(s).q, 0.0)
        grasp = replace(scene.grasp, s=s, tension=tension)
        force = np.array([0.0, 0.0, -tension])
        return replace(self._situation(joints, gripped=True, force=force), grasp=grasp)

    def _usual(self, request: Asked, expected: Reason, **changes: object) -> Case:
        situation = self._situation(robot_joints(self._start(), 0.0), **changes)
        return self._case(self._scenes[0], request, situation, expected, False)

    def _case(
        self,
        scene: GateScene,
        request: Asked,
        situation: Situation,
        expected: Reason | None,
        is_feasible: bool,
    ) -> Case:
        return Case(scene.verify, scene.config, request, situation, expected, is_feasible)

    def _situation(self, joints: Array, **changes: object) -> Situation:
        of_mode = {k: changes.pop(k) for k in _MODE if k in changes}
        measured = {"position": joints, "velocity": np.zeros(10), "effort": np.zeros(10)}
        measurement = Measurement(**{**measured, "stamp": NOW - 0.002, **changes})  # type: ignore[arg-type]
        mode = ControllerMode(State.ACTIVE, is_active=True)
        return Situation(measurement, NOW, joints, replace(mode, **of_mode))  # type: ignore[arg-type]


_MODE = ("state", "cause")
