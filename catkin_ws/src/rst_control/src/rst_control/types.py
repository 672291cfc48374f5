# SPDX-License-Identifier: BSD-3-Clause
"""Values that the stages exchange: frozen, arrays copied and read-only."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from enum import Enum

import numpy as np
from numpy.typing import ArrayLike, NDArray

Vector = NDArray[np.float64]
# Of settings.
Triple = tuple[float, float, float]
Point = Triple  # a place or a direction
Arm = tuple[float, float, float, float, float, float, float]  # a number for each joint

BASE = "base_link"  # frame of all poses, points and forces
ARM_JOINTS = tuple(f"joint_{i}" for i in range(1, 8))
ARM_COUNT = len(ARM_JOINTS)
JOINTS = (*ARM_JOINTS, "joint_pitch", "joint_finger_left", "joint_finger_right")
JOINT_COUNT = len(JOINTS)  # of the robot
PLAN_COUNT = 9  # of a planning configuration q: joint_1 .. joint_7, pitch, yaw


def frozen_array(values: ArrayLike, *shape: int) -> Vector:
    """Copy to a read-only float array.

    Raises:
        ValueError: The shape is another, or a value is not finite.
    """
    array = np.array(values, dtype=np.float64)
    if array.shape != shape:
        raise ValueError(f"array of shape {array.shape}, allowed: {shape}")
    if not all(map(math.isfinite, array.ravel().tolist())):  # of few numbers faster than by numpy
        raise ValueError("array with values that are not finite")
    array.flags.writeable = False
    return array


def unit_vector(direction: ArrayLike) -> Vector:
    """The direction at length 1. Any shape; its norm is not zero."""
    vector = np.array(direction, dtype=np.float64)
    unit: Vector = vector / np.linalg.norm(vector)
    return unit


@dataclass(frozen=True, eq=False, slots=True)
class Measurement:
    """What the robot side last said."""

    position: Vector  # (10,), [rad], order of JOINTS
    velocity: Vector  # (10,), [rad/s]
    effort: Vector  # (10,), [N m]
    stamp: float  # [s] steady clock, when it arrived
    force: Vector = field(default_factory=lambda: np.zeros(3))  # (3,), [N], of tissue on jaws, base
    gripped: bool = False  # tissue lies between the closed jaws
    connected: bool = True
    fault: str = ""  # as `robot_fault` reads it; empty: healthy
    tension_invalid_reason: str = ""  # why the force must not be relied on; empty: it may
    sent: float | None = (
        None  # [s] as `stamp`, when it was sent; wrong once a clock is set; None: not known
    )
    sent_to: Vector | None = None  # (10,), [rad], where it holds while nobody leads; None: unknown

    def __post_init__(self) -> None:
        for name in ("position", "velocity", "effort"):
            object.__setattr__(self, name, frozen_array(getattr(self, name), JOINT_COUNT))
        object.__setattr__(self, "force", frozen_array(self.force, 3))

    @property
    def tension(self) -> float:
        """Pull of the tissue on the jaws [N]."""
        x, y, z = self.force.tolist()
        return float((x * x + y * y + z * z) ** 0.5)


@dataclass(frozen=True, eq=False, slots=True)
class Setpoint:
    """Where the joints should be at a time."""

    position: Vector  # (10,), [rad], order of JOINTS
    velocity: Vector  # (10,), [rad/s]
    stamp: float  # [s]

    def __post_init__(self) -> None:
        for name in ("position", "velocity"):
            object.__setattr__(self, name, frozen_array(getattr(self, name), JOINT_COUNT))


@dataclass(frozen=True, slots=True)
class PathState:
    """Where on a path, how fast, how much faster."""

    s: float  # [m]
    speed: float = 0.0  # [m/s]
    acceleration: float = 0.0  # [m/s^2]


class Reason(Enum):
    """Why a command is refused, or a motion stopped or given up.

    The value is the `reason_code` of the messages, for programs.
    The sentences beside it are for people.
    """

    # a command is refused
    UNKNOWN_COMMAND = "unknown_command"
    WRONG_MODE = "wrong_mode"
    HALTED = "halted"
    BUSY = "busy"
    NOT_AT_REST = "not_at_rest"
    BY_HAND_ONLY = "by_hand_only"
    MAY_NOT_COMMAND = "may_not_command"
    TOO_MANY_CALLS = "too_many_calls"
    BAD_AMOUNT = "bad_amount"
    QUEUE_FULL = "queue_full"
    SITUATION_CHANGING = "situation_changing"
    CHECK_FAILED = "check_failed"
    WITHDRAWN = "withdrawn"
    NOTHING_GRASPED = "nothing_grasped"
    ALREADY_GRASPED = "already_grasped"
    ALREADY_THERE = "already_there"
    NOT_INSERTED = "not_inserted"
    UNREACHABLE = "unreachable"
    NO_GRASP = "no_grasp"
    JOINT_LIMIT = "joint_limit"
    RCM_TOLERANCE = "rcm_tolerance"
    WORKSPACE = "workspace"
    INSERTION_DEPTH = "insertion_depth"
    COLLISION = "collision"
    SINGULAR = "near_singular"
    TENSION_LIMIT = "tension_limit"
    DISPLACEMENT_LIMIT = "displacement_limit"
    TILT_LIMIT = "tilt_limit"
    NOT_CONFIRMED = "not_confirmed"
    NOT_THE_TROCAR = "not_the_trocar"
    NO_ANSWER = "no_answer"
    # a command is refused, or a motion braked and latched
    NOT_CONNECTED = "not_connected"
    FAULTED = "robot_fault"
    STALE = "joint_states_stale"
    NOT_RECORDED = "not_recorded"
    NO_MASTER = "no_master"
    NODE_LOST = "node_lost"
    VOICE_SILENT = "voice_silent"
    DEAD_MAN = "dead_man"
    SENSOR_FAULT = "sensor_fault"
    UNKNOWN_FRAME = "unknown_frame"
    TRACKER_STALE = "tracker_stale"
    TRACKER_JUMPED = "tracker_jumped"
    TRACKER_TOO_FAR = "tracker_too_far"
    ARM_FAULT = "arm_fault"
    ARM_IN_USE = "arm_in_use"
    ARM_NOT_READY = "arm_not_ready"
    ARM_LIMITS = "arm_limits"
    # a motion is braked and latched
    STOP_TOPIC = "stop_topic"
    STOP_COMMAND = "stop_command"
    STOP_CANCEL = "stop_cancel"
    SHUTDOWN = "shutdown"
    SETTINGS_CHANGED = "settings_changed"
    SETPOINTS_STOPPED = "setpoints_stopped"
    SETPOINT_REFUSED = "setpoint_refused"
    TENSION_SENSOR = "tension_sensor"
    JOINT_MESSAGES = "joint_messages"
    OFF_SETPOINT = "off_setpoint"
    OFF_TROCAR = "off_trocar"
    OVER_TENSION = "over_tension"
    SLIPPED = "slipped"
    OVERTIME = "overtime"
    LOOP_ERROR = "loop_error"
    # a motion is given up; nothing is latched
    NO_RESPONSE_TO_PULL = "no_response_to_pull"
    CLOSED_ON_NOTHING = "closed_on_nothing"
    CAUGHT_TISSUE = "caught_tissue"
    # a motion ends as asked; nothing is latched
    TERMINATED = "terminated"
    REPLACED = "replaced"


@dataclass(frozen=True)
class Cause:
    """Why something is refused, stopped or given up: a code for programs, words for people."""

    reason: Reason
    words: str  # names the value and what was allowed

    @property
    def coded(self) -> str:
        """Code and words in one text; `robot_fault` reads it."""
        return f"{self.reason.value}: {self.words}"


@dataclass(frozen=True)
class Rejected(Cause):
    """The command may not run."""

    @classmethod
    def by(cls, cause: Cause) -> Rejected:
        """Refused by a cause that is found elsewhere."""
        return cls(cause.reason, cause.words)


NOT_CONNECTED = Cause(Reason.NOT_CONNECTED, "robot not connected")
ROBOT_FAULTS = (
    Reason.FAULTED,
    Reason.SETPOINTS_STOPPED,
    Reason.SETPOINT_REFUSED,
    Reason.TENSION_SENSOR,
    Reason.JOINT_MESSAGES,
    Reason.SENSOR_FAULT,
    Reason.UNKNOWN_FRAME,
    Reason.TRACKER_STALE,
    Reason.TRACKER_JUMPED,
    Reason.TRACKER_TOO_FAR,
    Reason.ARM_FAULT,
    Reason.ARM_IN_USE,
    Reason.ARM_NOT_READY,
    Reason.ARM_LIMITS,
)


_BY_CODE = {reason.value: reason for reason in ROBOT_FAULTS}


def robot_fault(text: str) -> Cause:
    """Cause of a fault in the words of the robot's side: "words" or "code: words".

    Args:
        text: Without the code of one of ROBOT_FAULTS in front, it is a FAULTED.
    """
    code, _, words = text.partition(": ")
    reason = _BY_CODE.get(code)
    return Cause(Reason.FAULTED, text) if reason is None else Cause(reason, words)


class State(Enum):
    """What the controller is doing."""

    STANDBY = "standby"  # at rest, assistance not activated
    ACTIVE = "active"  # at rest, ready for a command
    MOVING = "moving"
    STOPPING = "stopping"  # braking along the path
    HALTED = "halted"  # at rest, latched by a person's stop
    FAULTED = "faulted"  # at rest, latched by a watchdog


LATCHED = (State.HALTED, State.FAULTED)
IN_MOTION = (State.MOVING, State.STOPPING)
ACTIVE_STATES = (State.ACTIVE, *IN_MOTION)  # from "hey robot" to rest after a stop


@dataclass(frozen=True)
class ControllerMode:
    """State of the controller, and the state that braking leads to."""

    state: State = State.STANDBY
    is_active: bool = False  # "hey robot" was said, and no "terminate" since
    mode_after: State = State.STANDBY  # where STOPPING ends
    cause: Cause | None = None  # why it is halted or faulted, or will be once at rest

    @property
    def reason(self) -> str:
        """The words of its cause; empty: there is none."""
        return self.cause.words if self.cause else ""

    @property
    def is_in_motion(self) -> bool:
        """A motion or its braking is under way."""
        return self.state in IN_MOTION

    @property
    def is_latched(self) -> bool:
        """Nothing moves until "hey robot"; true while still braking towards a latch, too."""
        is_latching = self.state is State.STOPPING and self.mode_after in LATCHED
        return self.state in LATCHED or is_latching
