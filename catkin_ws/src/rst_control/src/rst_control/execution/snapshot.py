# SPDX-License-Identifier: BSD-3-Clause
"""The controller after one tick, as other threads see it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

from rst_control.commands.request import Plan, Situation
from rst_control.execution.event_log import Event, EventLog
from rst_control.execution.motion import MotionProgress
from rst_control.execution.setpoint import SetpointState
from rst_control.planning.patient_surface import NOWHERE, TrocarPose
from rst_control.planning.plan import Grasp
from rst_control.trajectory.path import Path
from rst_control.types import NOT_CONNECTED, Cause, ControllerMode, Measurement, State, Vector


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class ControllerSnapshot:
    """The executor's state after one tick; never changes, so any thread may read it."""

    stamp: float  # [s]
    mode: ControllerMode
    serial: int  # changes whenever what verification looks at has changed, but for the measurement
    motion: MotionProgress | None  # None: at rest
    plan: Plan | None  # under way; None: at rest
    path: Path | None  # where the tip is, or last was; None: on no path
    path_position: float  # [m] of the tip on it
    command: str  # in execution, or the last one
    trocar_pose: TrocarPose  # of the measured joints
    measurement: Measurement | None
    setpoint: Vector | None  # (10,), [rad]
    grasp: Grasp | None
    last_refusal: Cause | None  # None: none was refused
    health: Cause | None  # why the robot is not fit for a motion; None: it is
    pulled: float | None  # [m] of the tissue from where it was grasped; None: none is held

    @classmethod
    def at_start(cls) -> ControllerSnapshot:
        """Before the first tick."""
        return cls(
            stamp=0.0,
            mode=ControllerMode(),
            serial=0,
            motion=None,
            plan=None,
            path=None,
            path_position=0.0,
            command="",
            trocar_pose=NOWHERE,
            measurement=None,
            setpoint=None,
            grasp=None,
            last_refusal=None,
            health=NOT_CONNECTED,
            pulled=None,
        )

    @property
    def phase(self) -> str:
        """Of the motion, or "brake" or "hold"."""
        if self.motion is None:
            return "hold"
        return "brake" if self.mode.state is State.STOPPING else self.motion.phase.value

    @property
    def rcm_error(self) -> float:
        """Measured distance of the shaft's line from the trocar [m]; zero while none was measured.

        While the tool is outside the patient it only informs.
        """
        return 0.0 if self.measurement is None else self.trocar_pose.error

    @property
    def insertion(self) -> float:
        """Measured depth of the tip in the trocar [m], negative outside; zero while none was."""
        return 0.0 if self.measurement is None else self.trocar_pose.insertion

    @property
    def is_moving(self) -> bool:
        """A motion or its braking is under way."""
        return self.mode.is_in_motion

    @property
    def latch(self) -> Cause | None:
        """Why nothing moves until "hey robot", or will not once braked; None: no latch."""
        return self.mode.cause if self.mode.is_latched else None

    @property
    def is_tissue_held(self) -> bool:
        """The jaws are closed on tissue."""
        return self.measurement is not None and self.measurement.gripped

    @property
    def tension(self) -> float:
        """Measured pull of the tissue on the jaws [N]; zero while nothing was measured."""
        return self.measurement.tension if self.measurement else 0.0

    @property
    def tension_target(self) -> float:
        """Tension that the grasp is to have [N]; zero where none is set."""
        return (self.grasp.tension if self.grasp else None) or 0.0

    def situation(self, now: float) -> Situation:
        """All that verification needs to know."""
        return Situation(
            measurement=self.measurement,
            now=now,
            setpoint=self.setpoint,
            mode=self.mode,
            grasp=self._grasp_now,
            pulled=self._pulled_at_grasp,
        )

    @property
    def _grasp_now(self) -> Grasp | None:
        """The grasp; while it is pulled to a tension, at the tip: no other place is its target."""
        grasp = self.grasp
        if grasp is None or grasp.tension is None or not self._is_pulled_on(grasp):
            return grasp
        return replace(grasp, s=self.path_position)

    @property
    def _pulled_at_grasp(self) -> float | None:
        """Pull at the place that the grasp says, which a motion under way has yet to reach [m]."""
        grasp = self._grasp_now
        if self.pulled is None or grasp is None or not self._is_pulled_on(grasp):
            return self.pulled
        return self.pulled + grasp.s - self.path_position

    def _is_pulled_on(self, grasp: Grasp) -> bool:
        """A motion along the pull of the grasp is under way."""
        return self.motion is not None and self.path is grasp.pull


# Changes something between two ticks, or leaves it, in the snapshot of that moment. It gives the
# event of what it did, None for nothing. The control loop runs it: it is quick and never raises.
Change = Callable[[ControllerSnapshot], Event | None]


def take_snapshot(
    now: float,
    mode: ControllerMode,
    serial: int,
    setpoint_state: SetpointState,
    event_log: EventLog,
    trocar_pose: TrocarPose,
    measured: Measurement | None,
    health: Cause | None,
    pulled: float | None,
) -> ControllerSnapshot:
    """What the executor looks like after a tick.

    Args:
        now: Time of the tick [s].
        mode: Its state.
        serial: Number of this situation.
        setpoint_state: Motion, set-point and grasp.
        event_log: Command and last refusal.
        trocar_pose: Of the measured joints.
        measured: Newest from the robot.
        health: Why no motion would be accepted; None: it would.
        pulled: How far tissue is pulled from where it was grasped [m]; None: none is held.
    """
    motion, place = setpoint_state.motion, setpoint_state.place
    holds = measured is not None and measured.gripped
    return ControllerSnapshot(
        stamp=now,
        mode=mode,
        serial=serial,
        motion=None if motion is None else motion.progress,
        plan=None if motion is None else motion.plan,
        path=place.path if place else None,
        path_position=place.state.s if place else 0.0,
        command=event_log.command,
        trocar_pose=trocar_pose,
        measurement=measured,
        setpoint=setpoint_state.held,
        grasp=setpoint_state.grasp if holds else None,
        last_refusal=event_log.last_refusal,
        health=health,
        pulled=pulled,
    )
