# SPDX-License-Identifier: BSD-3-Clause
"""The controller node: commands and action goals in, joint set-points out, 500 times a second."""

from __future__ import annotations

import gc
import sys
import time
from contextlib import ExitStack
from dataclasses import replace

import rospy

from rst_control.admission.callers import CallLimiter
from rst_control.admission.command_queue import CommandQueue, Verify
from rst_control.admission.dead_man_gate import DeadMan, HeldOnly
from rst_control.admission.homing_gate import HomingGate
from rst_control.admission.recording_gate import RecordedOnly, RecordingWatch
from rst_control.assembly import compensated, make_executor, make_trocar_context
from rst_control.config import ControllerConfig, MotionConfig
from rst_control.config.callers import CallersConfig
from rst_control.errors import RstError
from rst_control.execution.snapshot import ControllerSnapshot
from rst_control.kinematics.robot_model import RobotModel, parse_robot
from rst_control.msg import ControllerState, Event
from rst_control.registration.grasp_point import GraspHere, GraspPointRegistrar
from rst_control.registration.registrar import place_words
from rst_control.registration.tracked_grasp import TrackedGrasp
from rst_control.registration.trocar import FOLLOWED
from rst_control.registration.trocar_context import ActiveTrocarContext
from rst_control.registration.trocar_following import TrocarFollowing
from rst_control.robot.backend import RobotBackend
from rst_control.ros.common.exposure_warning import warn_of_listeners
from rst_control.ros.common.other_provider import other_provider
from rst_control.ros.common.priority import ask_for_priority
from rst_control.ros.common.republisher import Due
from rst_control.ros.common.wall_clock import RosClock
from rst_control.ros.controller.control_loop import ControlLoop
from rst_control.ros.controller.dead_man_link import DeadManLink
from rst_control.ros.controller.diagnostics import Diagnostics
from rst_control.ros.controller.liveness_watch import LivenessWatch
from rst_control.ros.controller.markers import ControllerMarkers
from rst_control.ros.controller.messages import event_message, state_message
from rst_control.ros.controller.places.frame_listener import FrameListener
from rst_control.ros.controller.places.places_in_force import PlacesInForce
from rst_control.ros.controller.places.tracker_link import TrackerLink
from rst_control.ros.controller.recording_link import RecordingLink
from rst_control.ros.controller.robot_link import RobotLink
from rst_control.ros.controller.services.action_server import AssistServer
from rst_control.ros.controller.services.command_service import COMMAND, CommandService
from rst_control.ros.controller.services.first_motion import ConfirmedFirst
from rst_control.ros.controller.services.grasp_point_service import GraspPointService
from rst_control.ros.controller.services.homing_service import HomingService
from rst_control.ros.controller.services.trocar_service import TrocarService
from rst_control.ros.controller.settings_watch import SettingsWatch
from rst_control.ros.controller.worker import Worker
from rst_control.ros.rospy_patches.message_limits import limit_messages
from rst_control.ros.rospy_patches.nonblocking_publish import publish_without_waiting
from rst_control.supervision.node_liveness import NodeLiveness
from rst_control.supervision.tension_trust import about_gain
from rst_control.types import Cause, Reason, State
from typed_config import ConfigError, load_config
from typed_config.ros.known_publishers import KnownPublishers
from typed_config.ros.launch_settings import launch_settings
from typed_config.ros.private_settings import robot_description
from typed_config.ros.starting import starting
from typed_config.ros.system_names import of_this_system

FEEDBACK_RATE = 20.0  # [Hz] to action clients
DIAGNOSTICS_PERIOD = 1.0  # [s]
COLLECT_PERIOD = 30.0  # [s] between collections of garbage, at rest only
BRAKING_TIME = 1.0  # [s] that a motion gets to brake when the node is shut down


class ControllerNode:
    """Everything that belongs to the node, as a context: inside it the loop runs.

    Args:
        config: Settings.
        model: The robot.
    """

    def __init__(self, config: MotionConfig, model: RobotModel) -> None:
        settings = config.controller
        self._clock = RosClock()
        self._known = KnownPublishers()
        self._link = RobotLink(
            self._clock,
            settings.watchdogs,
            settings.tension.source,
            self._known,
            settings.believed,
        )
        self._context = ActiveTrocarContext(make_trocar_context(config, model), time.monotonic())
        self._places = PlacesInForce(self._context, self._clock)
        self._liveness = NodeLiveness()
        self._executor = make_executor(
            config, self._context, self._link.clear_fault, self._liveness
        )
        grasp_point = GraspPointRegistrar(self._context, self._executor)
        limiter = CallLimiter(_in_any_namespace(settings.callers), time.monotonic)
        verify = self._join_gates(settings, grasp_point, limiter)
        self._commands = CommandQueue(self._executor, verify, time.monotonic)
        self._loop = ControlLoop(self._tick, self._executor.crashed, 1.0 / settings.rate)
        self._state = rospy.Publisher("rst_control/state", ControllerState, queue_size=2)
        self._event = rospy.Publisher("rst_control/event", Event, queue_size=100)
        self._markers = ControllerMarkers(config, self._context, self._look, self._clock)
        self._diagnostics = Diagnostics()
        self._settings = SettingsWatch(self._executor.stop)
        self._actions = AssistServer(self._commands, self._executor, limiter, self._known)
        self._spoken_by = of_this_system(settings.spoken_by)
        self._service = CommandService(
            self._commands,
            self._executor,
            limiter,
            self._spoken_by,
            settings.watchdogs.voice_heartbeat_age,
            self._known,
        )
        self._state_period = 1.0 / settings.state_rate
        self._feedback_due = Due(1.0 / FEEDBACK_RATE)
        self._diagnostics_due, self._collect_due = Due(DIAGNOSTICS_PERIOD), Due(COLLECT_PERIOD)
        self._is_sending = False
        self._stack = ExitStack()
        self._join_places(config, model, grasp_point, limiter)

    def _join_gates(
        self, settings: ControllerConfig, grasp_point: GraspPointRegistrar, limiter: CallLimiter
    ) -> Verify:
        """All that a command has to pass."""
        believed = settings.believed
        watch = RecordingWatch(settings.recording, time.monotonic)
        self._recording = RecordingLink(watch, self._executor, self._known, believed.recorder)
        dead_man = DeadMan(settings.watchdogs.dead_man_age, time.monotonic)
        self._dead_man = DeadManLink(dead_man, self._executor, self._known, believed.pedal)
        homing = HomingGate(settings, lambda: self._context.current.planner.patient, time.monotonic)
        self._homing = HomingService(homing, self._look)
        verify: Verify = RecordedOnly(GraspHere(self._context.verify, grasp_point), watch)
        verify = HeldOnly(verify, dead_man)
        if settings.first_motion == "confirmed":
            return ConfirmedFirst(verify, self._context, homing, limiter).verify
        return verify

    def _join_places(
        self,
        config: MotionConfig,
        model: RobotModel,
        grasp_point: GraspPointRegistrar,
        limiter: CallLimiter,
    ) -> None:
        """What sets trocar and grasp point by hand, and what follows them."""
        settings = config.controller
        self._trocar = TrocarService(self._context, self._executor, self._places, limiter)
        frames = FrameListener(self._clock, settings.tracking, self._known)
        self._grasp_point = GraspPointService(grasp_point, self._places, frames, limiter)
        follows = settings.tracking.trocar.motion == FOLLOWED
        robot = compensated(self._link, config, self._state_of)
        where = self._context.trocar_pose
        following = (
            TrocarFollowing(robot, config, model, self._state_of, where) if follows else None
        )
        self._robot: RobotBackend = following or robot
        tracked = TrackedGrasp(settings.tracking, self._context, grasp_point)
        self._tracker = TrackerLink(
            *(settings.tracking, self._known, frames, self._clock, tracked, following),
            self._context.configured.trocar,
        )

    def __enter__(self) -> ControllerNode:
        self._executor.tick(time.monotonic(), None)  # so that the first state has a time of its own
        self._diagnostics.priority = ask_for_priority()
        links = (self._service.heartbeats, self._actions.start())
        watch = LivenessWatch(
            self._liveness, self._executor, self._spoken_by, links, self._recording, self._dead_man
        )
        for name, step in (
            ("planning", self._plan),
            ("publishing", self._publish),
            ("markers", self._markers.step),
            ("action", lambda: self._actions.take_news(timeout=0.2)),
            ("tracker", self._tracker.step),
            ("peers", watch.peers.step),
            ("liveness", watch.step),
            ("settings", self._settings.step),
        ):
            self._stack.enter_context(Worker(name, step, self._diagnostics.error))
        self._stack.enter_context(self._loop)
        self._service.start()
        self._trocar.start()
        self._grasp_point.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._stack.close()

    def close(self) -> None:
        """Bring the robot to rest, then end all threads; called before the topics are closed."""
        self._executor.stop(Cause(Reason.SHUTDOWN, "the controller is being shut down"))
        end = time.monotonic() + BRAKING_TIME
        while self._executor.snapshot.is_moving and time.monotonic() < end:
            time.sleep(0.005)
        time.sleep(3 * self._state_period)  # the last events are still to be sent
        self._stack.close()

    def _tick(self, due: float) -> None:
        setpoint = self._executor.tick(due, self._robot.measured_js())
        if setpoint is not None:
            self._robot.servo_jp(setpoint)
        elif self._is_sending:
            self._robot.hold()
        self._is_sending = setpoint is not None

    def _look(self) -> ControllerSnapshot:
        return self._executor.snapshot

    def _state_of(self) -> State:
        return self._executor.snapshot.mode.state

    def _plan(self) -> None:
        queued = self._commands.next(timeout=0.2)
        if queued is None:
            return
        try:
            self._commands.check(queued)
        except Exception as error:  # the caller must hear of it; the worker reports it
            self._commands.fail(queued, error)
            raise

    def _publish(self) -> None:
        time.sleep(self._state_period)
        view = self._executor.snapshot
        self._state.publish(state_message(view, self._clock, self._context))
        self._places.step()
        while self._executor.events:
            self._event.publish(event_message(self._executor.events.popleft(), self._clock))
        now = time.monotonic()
        if self._feedback_due(now):
            self._actions.publish_feedback()
        if self._diagnostics_due(now):
            loop, age = self._loop.statistics.summary(), now - self._commands.last_command
            places = place_words(self._context, now)
            strangers = self._known.status("rst_control", "controller")
            others = (
                self._recording.status(),
                self._tracker.status(),
                strangers,
                self._settings.status(),
            )
            self._diagnostics.publish(view, loop, self._link.objection, age, places, others)
        if not view.is_moving and self._collect_due(now):
            gc.collect()


def _in_any_namespace(callers: CallersConfig) -> CallersConfig:
    """Callers that are allowed, by their names in this system, and as they are without one."""
    both = (*callers.allowed, *map(of_this_system, callers.allowed))
    return replace(callers, allowed=tuple(dict.fromkeys(both)))


def main() -> None:
    """Run the controller node."""
    limit_messages()
    publish_without_waiting()
    with starting(
        "controller", __doc__, refusals=(ConfigError, RstError), launch="controller.launch"
    ):
        if other := other_provider(COMMAND):
            rospy.logfatal(f"the controller cannot start: {other} is one already; end it first")
            sys.exit(2)
        config = load_config(MotionConfig, launch_settings(), "controller parameters")
        model = parse_robot(robot_description())
        node = ControllerNode(config, model)
    with node:
        rospy.on_shutdown(node.close)
        warn_of_listeners()
        if words := about_gain(config):
            rospy.loginfo(words)
        rospy.loginfo("controller ready; it waits for the robot and for commands")
        rospy.spin()
