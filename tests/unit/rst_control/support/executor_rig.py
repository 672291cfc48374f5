# SPDX-License-Identifier: BSD-3-Clause
"""A controller without ROS on a robot without physics, ticked by hand."""

from functools import lru_cache, partial

import numpy as np

from rst_control.admission.command_queue import CommandQueue
from rst_control.assembly import make_executor, make_trocar_context
from rst_control.config import load_motion_config
from rst_control.kinematics.configuration import Configuration, planning_joints, robot_joints
from rst_control.kinematics.robot_model import load_robot
from rst_control.registration.trocar_context import ActiveTrocarContext
from rst_control.supervision.node_liveness import NodeLiveness
from rst_control.types import Cause, Reason, State
from tests.support.changed_settings import changed
from tests.support.fake_robot import FakeRobot, LinearSpring

PERIOD = 0.002
AT_ONCE = ("hey robot", "stop", "terminate")


@lru_cache(maxsize=1)
def shared():
    config, model = load_motion_config(), load_robot()
    return config, model, make_trocar_context(config, model)


def tip_of(joints, model=None):
    return Configuration(model or shared()[1], planning_joints(joints)[0]).tip


class Rig:
    """Time goes on only by `run`."""

    def __init__(self, stiffness=200.0, config=None, start=None, context=None):
        settings, _, usual = shared()
        self.config, context = config or settings, context or usual
        tip = partial(tip_of, model=context.planner.model)
        self.now = 10.0
        q = np.array(self.config.scene.home if start is None else start)
        begin = robot_joints(q, self.config.scene.home_opening)
        self.robot = FakeRobot(begin, lambda: self.now, tissue=LinearSpring(tip, stiffness))
        self.context = ActiveTrocarContext(context)
        self.rcm = lambda joints: self.context.trocar_pose(joints).error
        self.liveness = NodeLiveness()  # of other nodes
        self.executor = make_executor(
            self.config, self.context, self.robot.clear_fault, self.liveness
        )
        self.queue = CommandQueue(self.executor, self.context.verify, lambda: self.now)
        self.sent = []  # every set-point, None where nothing was sent

    def believing(self):
        """Any measurement is believed, so that what else it leads to can be seen."""
        self.executor._watchdogs.update = lambda *_: None
        return self

    def tick(self):
        self.now += PERIOD
        setpoint = self.executor.tick(self.now, self.robot.measured_js())
        if setpoint is not None:
            self.robot.servo_jp(setpoint)
        self.sent.append(setpoint)
        return setpoint

    def run(self, seconds):
        for _ in range(round(seconds / PERIOD)):
            self.tick()
        return self

    def until(self, condition, limit=30.0):
        for _ in range(round(limit / PERIOD)):
            if condition():
                return self
            self.tick()
        raise AssertionError(f"not within {limit} s; {self.executor.snapshot}")

    def worst_error_until(self, condition):
        """Largest distance of the shaft from the trocar until then [m]."""
        worst = 0.0
        while not condition():
            self.tick()
            worst = max(worst, self.view.trocar_pose.error)
        return worst

    def give(self, words, spoken=False, owner="", **amounts):
        """Give a command and tick until it is answered."""
        pending = self.queue.take(words, "test", spoken, owner=owner, **amounts)
        if words == "stop":  # answered before anybody ticks
            self.tick()
        while not pending.reply.done():
            waiting = self.queue.next(0.0) if words not in AT_ONCE else None
            if waiting is not None:
                self.queue.check(waiting)
            self.tick()
        return pending

    def verified(self, words="tense"):
        """Give a motion and have it verified; no tick has taken it up yet."""
        pending = self.queue.take(words, "test")
        self.queue.check(self.queue.next(0.0))
        return pending

    def stop(self):
        """Stop it by the topic; the next tick takes that up."""
        self.executor.stop(Cause(Reason.STOP_TOPIC, "test"))

    def say(self, words, **more):
        """Give a command that must be accepted."""
        pending = self.give(words, **more)
        assert pending.reply.result(0).accepted, pending.reply.result(0).message
        return pending

    def refused(self, words, **more):
        """Give a command that must be refused; returns the reason."""
        reply = self.give(words, **more).reply.result(0)
        assert not reply.accepted, reply.message
        return reply.message

    def finish(self, words, **more):
        """Give a motion and carry it out to its end."""
        pending = self.say(words, **more)
        self.until(pending.ended.done, limit=120.0)
        assert pending.ended.result(0).kind == "succeeded", pending.ended.result(0)
        return pending.ended.result(0)

    def awake(self):
        self.run(0.01)
        self.say("hey robot")
        return self

    def moving(self, *phases):
        """Set off with "tense" and go on until one of the phases is well under way."""
        self.awake().say("tense")
        return self.until(lambda: self.phase in phases and self.view.motion.progress > 0.3)

    @property
    def view(self):
        return self.executor.snapshot

    @property
    def state(self):
        return self.view.mode.state

    @property
    def phase(self):
        return self.view.phase

    @property
    def joints(self):
        """Last set-point's joints."""
        return next(s.position for s in reversed(self.sent) if s is not None)

    def event_kinds(self):
        return [entry.kind for entry in self.executor.events]

    def rest(self, limit=2.0):
        """Go on until nothing moves."""
        return self.until(lambda: self.state not in (State.MOVING, State.STOPPING), limit)

    def still_for(self, seconds):
        """Whether the set-point stays exactly where it is."""
        before = self.joints
        self.run(seconds)
        return bool(np.array_equal(before, self.joints))


def with_watchdogs(**changes):
    """Settings with other watchdogs."""
    return changed(shared()[0], watchdogs=changes)
