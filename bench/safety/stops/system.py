# SPDX-License-Identifier: BSD-3-Clause
"""Stops in the running system: by service, topic and action cancel, from one and from many.

Controller and simulated robot as nodes. Received is a stop when the controller's transport hands it
over: that time is the stamp of its event on `rst_control/event`. Answered it is by the
first set-point due after it that is slower than the one before. Both carry the controller's own
stamps; how long the answer truly took on its way is given beside, from the moment a client sent its
stop to the arrival of that set-point at this process.

In one motion after the other: "hey robot", a pull as an action goal, the stop at a random moment.
Fifty clients at once make fifty stops of one motion, so 10,000 of them take about ten minutes. In
the environment: STOPS of them (10,000), CLIENTS at once (50).
"""

from __future__ import annotations

import os
import tempfile
import time
from collections import Counter, deque
from collections.abc import Callable
from pathlib import Path

import actionlib
import numpy as np
import rospy
from actionlib_msgs.msg import GoalStatus
from sensor_msgs.msg import JointState

from bench.common.resumable import measured
from bench.safety.stops import judge
from bench.safety.stops.clients import WAYS, Clients
from bench.safety.stops.judge import JudgedStop, SetpointCourse, latency, objection, rest
from rst_control.assembly import make_trocar_context
from rst_control.config import load_motion_config
from rst_control.kinematics.configuration import planning_joints
from rst_control.kinematics.robot_model import load_robot
from rst_control.msg import AssistAction, AssistGoal, ControllerState, Event
from rst_control.srv import Command
from rst_control.types import JOINTS
from support.figures import ROOT, Figure, percentiles
from support.launched_system import READY_TIME, System

FULL = 10_000
STOPS = int(os.environ.get("STOPS", FULL))
CLIENTS = int(os.environ.get("CLIENTS", "50"))
SEED = 6
ALLOWED = 0.05  # [s] for set-points to rest; 45 ms along a path (limits.yaml), the jaws rest
WATCHED = 0.5  # [s] after a stop
KEPT = 4000  # messages of each stream: eight seconds
LONGEST = 0.6  # [s] of a pull before its stop
AT_REST = 0.15  # share of the stops that come at rest
LOW, HIGH, STEP = 0.5, 1.5, 0.4  # [N] between which pulls are kept, and one pull
LEAD = 0.03  # [s] before its moment that a client gets it
LIMIT = 20.0  # [s] for anything to happen
AT_ONCE = 0.01  # [s]
TRIES = 5  # to grasp: a watchdog may halt the robot where the machine pauses
RESTING = ("active", "halted", "faulted")
UNSEEN = "not in the event log"


class StopWatcher:
    """Keeps what the controller and the robot send."""

    def __init__(self) -> None:
        self.state: ControllerState | None = None
        self.events: deque[Event] = deque(maxlen=KEPT)
        self.setpoints: deque[tuple[float, JointState]] = deque(maxlen=KEPT)  # arrival [s], message
        self.joints: deque[tuple[float, JointState]] = deque(maxlen=KEPT)
        self._subscribers = [
            rospy.Subscriber("rst_control/state", ControllerState, self._on_state),
            rospy.Subscriber("rst_control/event", Event, self.events.append),
            self._stream("robot/servo_jp", self.setpoints),
            self._stream("joint_states", self.joints),
        ]

    def received(self) -> list[float]:
        """Times at which the controller received the stops in its event log [s]."""
        return [e.header.stamp.to_sec() for e in list(self.events) if e.kind == "stop_received"]

    def course(self) -> tuple[SetpointCourse, list[float]]:
        """Set-points of the last seconds, and when each arrived here [s]."""
        kept = list(self.setpoints)
        course = SetpointCourse(
            np.array([message.header.stamp.to_sec() for _, message in kept]),
            np.array([message.position for _, message in kept]),
            np.array([message.velocity for _, message in kept]),
        )
        return course, [arrived for arrived, _ in kept]

    def clear(self) -> None:
        """Forget all events."""
        self.events.clear()

    def wait(self, *states: str, unless: Callable[[], bool] = lambda: False) -> None:
        """Wait until the controller is in one of some states, or something else has happened.

        Raises:
            RuntimeError: It never was.
        """
        end = time.monotonic() + LIMIT
        while not unless() and (self.state is None or self.state.state not in states):
            if time.monotonic() > end:
                raise RuntimeError(f"never {' or '.join(states)}; the controller says {self.state}")
            time.sleep(0.005)

    def _on_state(self, state: ControllerState) -> None:
        self.state = state

    @staticmethod
    def _stream(name: str, kept: deque[tuple[float, JointState]]) -> rospy.Subscriber:
        def keep(message: JointState) -> None:
            kept.append((time.time(), message))

        return rospy.Subscriber(name, JointState, keep, tcp_nodelay=True)


class StopSession:
    """The robot, led from motion to motion, and stopped in each.

    Args:
        clients: Who stop.
        seed: Chooses moments.
    """

    def __init__(self, clients: Clients, seed: int) -> None:
        self.watcher, self._clients = StopWatcher(), clients
        self._rng = np.random.default_rng(seed)
        self._command = rospy.ServiceProxy("rst_control/command", Command)
        self._goals = actionlib.SimpleActionClient("rst_control/execute", AssistAction)
        self._context = make_trocar_context(load_motion_config(), load_robot())
        if not self._goals.wait_for_server(rospy.Duration(READY_TIME)):
            raise RuntimeError("the controller did not start")
        self.seen: list[float] = []  # [s] from the first client's call to its answer's arrival
        self.halts: list[str] = []  # reasons of halts before the stop, which then shows nothing

    def grasp(self) -> None:
        """Take tissue, once.

        Raises:
            RuntimeError: It was not taken.
        """
        for _ in range(TRIES):
            self._wake()
            self._goals.send_goal_and_wait(AssistGoal(command="tense"), rospy.Duration(60.0))
            self.watcher.wait(*RESTING)
            if self.watcher.state is not None and self.watcher.state.tissue_held:
                return
            self._note_halt()
        raise RuntimeError(f"no tissue was grasped in {TRIES} tries: {self.halts}")

    def stops(self, way: str, count: int) -> list[JudgedStop]:
        """Stop by one way, with as many clients at once, in motion or at rest."""
        is_moving = way == "cancel" or self._rng.random() > AT_REST  # at rest nothing is to cancel
        self._wake()
        self.watcher.clear()
        if is_moving and not self._pull():
            return []
        first = time.monotonic() + LEAD + float(self._rng.uniform(0.0, LONGEST if is_moving else 0))
        moments = (first + self._rng.uniform(0.0, 0.004, count)).tolist()
        sent = self._clients.stop(way, moments)
        received = self._received(max(sent) + time.time() - time.monotonic())
        if (received or way == "cancel") and self._was_halted(min(received, default=np.inf)):
            return []
        return self._judged(way, count, received, sent)

    def _received(self, sent: float) -> list[float]:
        """When the stops came [s], in order; one that came late is watched for as long."""
        received, newest = list[float](), sent
        while (left := newest + WATCHED - time.time()) > 0.0:
            time.sleep(left)
            received = sorted(self.watcher.received())
            newest = max([newest, *received])
        return received

    def _judged(
        self, way: str, count: int, received: list[float], sent: list[float]
    ) -> list[JudgedStop]:
        (course, arrivals), state = self.watcher.course(), self.watcher.state
        missed = "" if state is not None and state.halted else "not halted after the stop"
        if not received:
            return [JudgedStop("unknown", way, count, None, None, 0.0, UNSEEN)] * count
        rcm = self._rcm_error(received[0], received[-1] + WATCHED)
        stops: list[JudgedStop] = []
        for moment in received:
            late, objected = latency(course, moment), missed or objection(course, moment, ALLOWED)
            situation = "at rest" if late is None else "braking" if stops else "in motion"
            first = late if situation == "in motion" else None  # the others came into its braking
            ended = rest(course, moment)
            stops.append(JudgedStop(situation, way, count, first, ended, rcm, objected))
        self._note_arrival(course, arrivals, received[0], min(sent))
        lost = count - len(received)  # a cancelled goal is over: later cancels find none
        if lost > 0 and way != "cancel":
            stops += [JudgedStop("unknown", way, count, None, None, rcm, UNSEEN)] * lost
        return stops

    def _note_arrival(
        self, course: SetpointCourse, arrivals: list[float], received: float, sent: float
    ) -> None:
        late = latency(course, received)
        if late is None or not np.isfinite(late):
            return
        answer = int(np.searchsorted(course.stamps, received + late - 1e-6))
        wall = time.time() - time.monotonic()
        self.seen.append(arrivals[answer] - (sent + wall))

    def _rcm_error(self, since: float, until: float) -> float:
        """Largest RCM error of the joints measured meanwhile [m]."""
        errors = [0.0]
        for _, message in list(self.watcher.joints):
            if since <= message.header.stamp.to_sec() <= until:
                by_name = dict(zip(message.name, message.position, strict=True))
                joints = np.array([by_name[name] for name in JOINTS])
                errors.append(
                    self._context.planner.patient.trocar_pose(planning_joints(joints)[0]).rcm_error
                )
        return max(errors)

    def _wake(self) -> None:
        end = time.monotonic() + LIMIT
        while not self._command("hey robot").accepted:
            if time.monotonic() > end:
                raise RuntimeError(
                    f'"hey robot" is refused; the controller says {self.watcher.state}'
                )
            time.sleep(0.02)
        self.watcher.wait("active", "moving")

    def _pull(self) -> bool:
        """Set off with a pull, as an action goal that can be cancelled; gives whether it moves."""
        state = self.watcher.state
        if state is None or not state.tissue_held:
            self.grasp()
        is_low = state is None or state.tension < 0.5 * (LOW + HIGH)
        self._goals.send_goal(AssistGoal("pull more" if is_low else "pull less", STEP, 0.0))
        self.watcher.wait("moving", "halted", "faulted", unless=self._is_refused)
        return not self._was_halted() and not self._is_refused()

    def _is_refused(self) -> bool:
        """Whether the last goal was, as where a busy machine's joint states are late."""
        return bool(self._goals.get_state() == GoalStatus.REJECTED)

    def _was_halted(self, before: float = np.inf) -> bool:
        """Whether a watchdog halted the robot before a moment [s]; notes which one."""
        events = list(self.watcher.events)
        limit = before - AT_ONCE  # a stop at rest halts with the stamp of the tick that it came in
        found = any(e.kind == "halted" and e.header.stamp.to_sec() < limit for e in events)
        if found:
            self._note_halt()
        return found

    def _note_halt(self) -> None:
        state = self.watcher.state
        self.halts.append(state.halt_reason_code if state is not None else "")


def measure() -> list[Figure]:
    """Run the controller and the robot, and stop them again and again.

    Raises:
        RuntimeError: The system did not start, or a part of it ended.
    """
    with tempfile.TemporaryDirectory() as name, System(Path(name) / "launch.log", {}) as system:
        rospy.init_node("bench", anonymous=True, disable_signals=True)
        system.launch(ROOT / "launch" / "robot.launch")
        system.launch(ROOT / "launch" / "controller.launch", on_recording_loss="ignore")
        with Clients(CLIENTS) as clients:
            return _measured(system, StopSession(clients, SEED))


def _measured(system: System, session: StopSession) -> list[Figure]:
    session.grasp()
    stops: list[JudgedStop] = []
    begin, done = time.monotonic(), 0
    while len(stops) < STOPS:
        if not system.is_running():
            raise RuntimeError("a part of the system ended")
        way, count = WAYS[done % len(WAYS)], CLIENTS if done % 8 >= 6 else 1
        stops += session.stops(way, count)
        done += 1
    period = 1.0 / load_motion_config().controller.rate
    figures = [measured(len(stops), "stops", FULL)]
    figures += judge.figures("running system", stops, STOPS, period)
    if session.seen:
        what = "running system: stop sent to first slower set-point received elsewhere"
        figures += percentiles(what, [seconds * 1e3 for seconds in session.seen], "ms")
    minutes = (time.monotonic() - begin) / 60.0
    halts = Counter(session.halts)
    listed = "; ".join(f"{count} {code}" for code, count in halts.most_common())
    what = "running system: motions that a watchdog halted before their stop, left out"
    figures.append(Figure(what, len(session.halts), "", note=f"({listed})" if listed else ""))
    note = f"({done} motions and rests, {CLIENTS} clients)"
    return [*figures, Figure("running system: time taken", minutes, "min", note=note)]
