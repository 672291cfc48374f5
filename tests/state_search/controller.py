# SPDX-License-Identifier: BSD-3-Clause
"""The real executor as a graph: every state that any inputs lead to, each input tried in each.

Executor, set-point, motion, watchdogs, event log and state machine are the product's own. What a
phase does with numbers is left out: it goes on until an input says that it has arrived. States are
distinguished by all that a later tick may depend on (`Controller.key`). A test checks that.
"""

from __future__ import annotations

import gc
import logging
from collections import deque
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from rst_control.commands.spec import Load
from rst_control.config import load_motion_config
from rst_control.execution.event_log import Event
from rst_control.execution.executor import Executor
from rst_control.execution.inbox import Inbox
from rst_control.execution.motion import MotionMaker
from rst_control.execution.orders import Order
from rst_control.execution.setpoint import SetpointState
from rst_control.kinematics.configuration import planning_joints
from rst_control.planning.patient_surface import TrocarPose
from rst_control.planning.plan import PhaseKind
from rst_control.supervision.node_liveness import NodeLiveness
from rst_control.supervision.watchdogs import WatchdogLimits, Watchdogs
from rst_control.types import JOINT_COUNT, Cause, PathState, Reason, State
from tests.state_search.inputs import (
    FOUND,
    LATE,
    LOST,
    MOTIONS,
    OWNER,
    ZERO,
    Given,
    Input,
    inputs,
    plan_of,
)
from tests.state_search.rules import objection

TINY = np.full(JOINT_COUNT, 1e-9)  # [rad] of a tick in motion: enough to see that it moved


@dataclass(frozen=True)
class Edge:
    """What an input leads to."""

    to: tuple
    has_changed: bool  # what was verified before is verified no longer
    started: Given | None
    outcomes: tuple[str, ...]  # of the orders: accepted, refused, stale, or "" for not yet


class _World:
    """What the runs meet in the present tick; set before each."""

    found = "well"


class _Sensors:
    """Whether measurements are believed is up to the input, too."""

    @property
    def objection(self):
        return "cannot be true" if _World.found == "sensor fault" else ""

    tension_objection = ""

    def update(self, measured, setpoint, pulled):
        pass


class _Trust:
    """Believes every tension."""

    def judge(self, measured, held):
        return measured

    def pulled(self, held):
        return None


class _Run:
    """A phase whose end is up to the input."""

    def __init__(self, phase, held):
        self.phase, self._held = phase, held
        self.is_done, self.failure = False, None
        self.is_pulling = phase.kind in (PhaseKind.PULL, PhaseKind.STEP)
        self.state, self.progress = PathState(0.0), 0.0
        self.is_braking = False

    def step(self, dt, measured):
        self.is_done = _World.found.endswith("arrived")
        if _World.found == "failing" and not self.is_braking:
            self.failure = Cause(Reason.NO_RESPONSE_TO_PULL, "no answer")
        self._held = self._held + TINY
        return self._held, ZERO

    def brake(self):
        self.is_braking, self.is_pulling = True, False


class _Maker(MotionMaker):
    def __init__(self):
        self.period = 0.002

    def start_phase(self, phase, held, place):
        return _Run(phase, held)


@lru_cache(maxsize=1)
def limits():
    config = load_motion_config()
    settings = config.controller
    return WatchdogLimits(settings.watchdogs, config.rcm.measured_tolerance, settings.tension.limit)


def _place(position):
    is_off = abs(position[0] - 0.02) < 1e-3
    return TrocarPose(0.02 if is_off else 0.0, 0.1, 0.1, -0.1, is_outside=False)


def _jaws(setpoint):
    """Opening that they are sent to, or were before the set-point was forgotten [rad]."""
    sent = setpoint._sent_to if setpoint.held is None else planning_joints(setpoint.held)[1]
    return round(float(sent), 3)


def _twin(thing):
    twin = object.__new__(type(thing))
    twin.__dict__.update(thing.__dict__)
    return twin


class Controller:
    """A real executor that can be copied, and asked what it would do."""

    def __init__(self):
        self.liveness = NodeLiveness()  # set before each tick, so that copies may share it
        watchdogs = Watchdogs(limits(), _Sensors(), self.liveness)
        self.executor = Executor(
            watchdogs, _place, SetpointState(_Maker()), _nothing, 0.002, _Trust()
        )
        self.now = 10.0

    def fork(self):
        """A copy that shares nothing that changes."""
        twin = _twin(self)
        executor = twin.executor = _twin(self.executor)
        executor._inbox, executor._robot = Inbox(), _twin(executor._robot)
        fault_reset = executor._fault_reset = _twin(executor._fault_reset)
        fault_reset._objection, fault_reset._refuse = executor._cannot_activate, executor._refuse
        executor._event_log = _twin(executor._event_log)
        executor._event_log.events = deque()
        setpoint = executor._setpoint_state = _twin(executor._setpoint_state)
        if setpoint.motion is not None:
            motion = setpoint.motion = _twin(setpoint.motion)
            motion._waiting, motion._run = deque(motion._waiting), _twin(motion._run)
        return twin

    def key(self):
        """All that later ticks depend on, but for words and times."""
        executor = self.executor
        mode, setpoint = executor._mode, executor._setpoint_state
        return (
            *(mode.state, mode.is_active, mode.mode_after),
            *(self._moving(), _where(setpoint.held), setpoint.grasp is None),
            *(executor._event_log.order is None, mode.cause is not None),
            _jaws(setpoint),
            executor._fault_reset._waiting is None,
        )

    def _moving(self):
        motion, mode = self.executor._setpoint_state.motion, self.executor._mode
        is_spoken = self.executor._event_log.is_spoken
        if motion is None:
            return None
        if not motion._is_braking:
            return (
                *(is_spoken, motion.raises_tension, motion.needs_grip, motion.can_retarget),
                *(len(motion._waiting), motion._run.is_done, bool(motion.failure)),
                motion.plan.command.load is Load.LOADS,
            )
        is_watched = mode.mode_after is not State.FAULTED  # as Executor._watch has it
        return is_watched and is_spoken, is_watched and motion.raises_tension

    def take(self, given):
        """Carry an input out; returns the edge."""
        executor = self.executor
        serial, running = executor._serial, executor._setpoint_state.motion
        outcomes = [""] * len(given.orders)
        for n, order in enumerate(given.orders):
            executor.post(_order(order, serial, executor.latches, outcomes, n))
        if given.is_stopped:
            executor.stop(Cause(Reason.STOP_TOPIC, "stop"))
        if given.is_changed:
            executor.change(lambda view: Event(self.now, "trocar_set", "", ""))
        self._tick(given.found)
        taken = [
            order
            for order, outcome in zip(given.orders, outcomes, strict=True)
            if outcome == "accepted" and order.command in MOTIONS
        ]
        motion = executor._setpoint_state.motion
        started = taken[-1] if taken else None
        if started is None and motion is not None and motion is not running:
            started = Given(motion.plan.command, is_fresh=False)  # by nobody's order
        return Edge(self.key(), executor._serial != serial, started, tuple(outcomes))

    def _tick(self, found):
        _World.found = found
        self.liveness.report({LOST[found]: "ended"} if found in LOST else {})
        self.now += LATE.get(found, 0.0)
        if found == "crash":
            self.executor.crashed(ArithmeticError("x"))
            return
        if found != "silent":
            self.executor.heartbeat(self.now)
        was_seen = self.executor._robot.measurement is not None
        is_absent = found == "nobody" and was_seen  # once seen, a robot that is gone says so
        self.executor.tick(self.now, FOUND["gone" if is_absent else found])


def _where(held):
    """Where the set-point stands; it is taken anew from joints that were pushed away, too."""
    if held is None:
        return "nowhere"
    return "away" if held[0] > 0.2 else "here"


def _nothing():
    pass


def _order(given, serial, latches, outcomes, n):
    def reply(answer):
        outcomes[n] = "accepted" if answer.accepted else "refused"

    def stale():
        outcomes[n] = "stale"

    is_motion = given.command in MOTIONS
    of = serial if given.is_fresh else serial - 1
    return Order(
        plan_of(given.command),
        of if is_motion else -1,
        latches,
        given.is_spoken,
        OWNER,
        reply=reply,
        stale=stale if is_motion else None,
    )


@dataclass
class Graph:
    """All states of the controller with all their edges."""

    edges: dict[tuple, dict[Input, Edge]]
    example: dict[tuple, Controller]  # one for each state
    way: dict[tuple, tuple[Input, ...]]  # shortest that leads there
    objections: list[tuple[str, tuple[Input, ...]]]  # with the way there

    @cached_property
    def table(self):
        """For each state, in the order of `edges`: the number of the next one, and the edge."""
        number = {key: n for n, key in enumerate(self.edges)}
        return [
            {given: (number[edge.to], edge) for given, edge in edges.items()}
            for edges in self.edges.values()
        ]

    @property
    def depth(self):
        return max(len(way) for way in self.way.values())


def explore(given=None, deepest=None, is_first_enough=False):
    """Breadth first from the start to the fixed point, or to a depth."""
    given, start = given or inputs(), Controller()
    graph = Graph({}, {start.key(): start}, {start.key(): ()}, [])
    waiting = deque([start.key()])
    logging.disable(logging.CRITICAL)  # each crash would be logged in full
    with _no_garbage():
        try:
            _widen(graph, waiting, given, deepest, is_first_enough)
        finally:
            logging.disable(logging.NOTSET)
    return graph


@contextmanager
def _no_garbage():
    """All that is made is kept, so nothing is gained by looking for what is not, then or later."""
    gc.collect()
    gc.disable()
    try:
        yield
    finally:
        gc.freeze()
        gc.enable()


def _widen(graph, waiting, given, deepest, is_first_enough):
    while waiting:
        key = waiting.popleft()
        way, edges = graph.way[key], graph.edges.setdefault(key, {})
        if deepest is not None and len(way) >= deepest:
            continue
        for what in given:
            twin = graph.example[key].fork()
            before = twin.executor._setpoint_state.held
            edges[what] = edge = twin.take(what)
            held = (before, twin.executor._setpoint_state.held)
            if words := objection(key, what, edge, held):
                graph.objections.append((words, (*way, what)))
                if is_first_enough:
                    return
            if edge.to not in graph.example:
                graph.example[edge.to], graph.way[edge.to] = twin, (*way, what)
                waiting.append(edge.to)
