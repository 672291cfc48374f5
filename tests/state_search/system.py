# SPDX-License-Identifier: BSD-3-Clause
"""Dialogue, queue, recording and controller together: every state that any events lead to.

The controller is the graph of `searched_controller`. Mapper, dialogue, queue, the rule of recording
and the refusals by mode are the product's own, asked for every state in which they can be asked.
What is planned and measured is left to chance: whatever the mode lets pass may be verified.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field
from functools import cache
from itertools import product
from types import SimpleNamespace
from typing import Any, NamedTuple

from rst_control.admission import command_queue
from rst_control.admission.recording_gate import RecordedOnly, RecordingWatch
from rst_control.commands.preconditions import mode_refusal
from rst_control.commands.request import Accepted
from rst_control.commands.spec import CommandSpec, Load
from rst_control.commands.table import COMMANDS
from rst_control.config.recording import RecordingConfig
from rst_control.types import State
from tests.state_search.controller import Graph
from tests.state_search.inputs import FOUND, MOTIONS, TRIED, Given, one, plan_of
from tests.state_search.rules import is_latched
from voice_assist.config import load_voice_config
from voice_assist.intent import dialogue
from voice_assist.intent.mapper import Mapper
from voice_assist.types import Call, Halt, Match, Mode, SetMode

SPOKEN = load_voice_config().commands
TALK = ("they will pull more people in", "do not stop pulling it", "the patient was tense all day")
STOPS = ("topic", "service", "cancel", "shutdown")  # all are Executor.stop


class Waiting(NamedTuple):
    """A motion on its way through the queue."""

    command: CommandSpec
    is_spoken: bool
    heard_in: Mode | None  # of a spoken one
    is_verifying: bool = False  # else it waits for its turn
    is_fresh: bool = True  # the situation is still the one in which it is verified


class System(NamedTuple):
    """One state of it all; the recorder may be there or not at any moment, so it is no part."""

    controller: int  # number of its state in the graph
    mode: Mode = Mode.STANDBY
    pending: Waiting | None = None
    is_stopped: bool = False  # by the newest of stop and accepted "hey robot"


class _Posted:
    """Stands for the executor towards the queue, and keeps what it is given."""

    def __init__(self):
        self.orders, self.stops, self.latches = [], [], 0
        self.snapshot = SimpleNamespace(serial=1, situation=lambda now: None)

    def post(self, order):
        self.orders.append(order)

    def stop(self, reason, *more):
        self.stops.append(reason)

    def note_refusal(self, *words):
        pass


def _watch(on_loss, is_recorded):
    watch = RecordingWatch(RecordingConfig(on_loss=on_loss, heartbeat_age=2.0), lambda: 0.0)
    if is_recorded:
        watch.heard("recorder", "")
    return watch


@dataclass
class Search:
    """All states of the system, breadth first.

    Args:
        graph: The controller.
        on_loss: Setting of the recording.
    """

    graph: Graph
    on_loss: str = "refuse"
    found: dict[System, tuple[System, str] | None] = field(default_factory=dict)
    depth: int = 0
    transitions: int = 0
    objections: list[tuple[str, list[str]]] = field(default_factory=list)

    def __post_init__(self):
        self._mapper = Mapper(SPOKEN)
        self.keys = list(self.graph.edges)
        self.table = self.graph.table
        self.hear, self.queue = cache(self._hear), cache(self._queue)
        self.report = cache(self._report)
        self.refused, self.passes = cache(self._refused), cache(self._passes)
        self.must_stop = cache(self._must_stop)

    def run(self, deepest=None, is_first_enough=False):
        """Go on to the fixed point, or to a depth."""
        start = System(0)
        self.found, edge = {start: None}, [start]
        while edge and (deepest is None or self.depth < deepest):
            beyond: list[System] = []
            for state in edge:
                for name, after, words in self._steps(state):
                    self.transitions += 1
                    if after not in self.found:
                        self.found[after] = (state, name)
                        beyond.append(after)
                    if words:
                        self.objections.append((words, [*self.way(state), name]))
                        if is_first_enough:
                            return self
            self.depth += bool(beyond)
            edge = beyond
        return self

    def way(self, state):
        """Shortest sequence of events that leads there."""
        steps: deque[str] = deque()
        while (last := self.found[state]) is not None:
            state = last[0]
            steps.appendleft(last[1])
        return list(steps)

    # What may happen.

    def _steps(self, state):
        yield from self._voice(state)
        yield from self._reports(state)
        for command in TRIED:
            for by, is_spoken in (("service", False), ("action", False), ("voice's node", True)):
                yield from self._given(state, command, by, is_spoken)
        for way in STOPS:
            yield self._tick(state, f"stop by {way}", one(is_stopped=True))
        for name in FOUND:
            yield self._tick(state, name, one(found=name))
        yield self._tick(state, "trocar set", one(is_changed=True))
        if self.must_stop(state.controller):
            yield self._tick(state, "unrecorded, so it stops", one(is_stopped=True))
        yield from self._verification(state)

    def _voice(self, state):
        for text in TALK:
            done = self.hear(text, state.mode)
            yield text, state, f"talk did {done.actions}" if done.actions else ""
        for config in SPOKEN.commands:
            done = self.hear(config.phrase, state.mode)
            heard = state._replace(mode=done.state.mode)
            name = f'said "{config.phrase}"'
            yield f"{name}, its call is lost", heard, ""
            if any(isinstance(action, Halt) for action in done.actions):
                yield self._tick(heard, name, one(is_stopped=True))
            calls = [a.command for a in done.actions if isinstance(a, Call)]
            for command in map(COMMANDS.__getitem__, calls):
                yield from self._given(heard, command, name, True, state.mode)

    def _reports(self, state):
        """The robot's mode reaches the voice: that of now, or one that the network held back."""
        now = Mode.ACTIVE if self.keys[state.controller][1] else Mode.STANDBY
        for mode in Mode:
            done = self.report(state.mode, mode)
            words = ""
            if not all(isinstance(action, SetMode) for action in done.actions):
                words = f"a report did {done.actions}"
            if mode is now and done.state.mode is not now:
                words = "the voice is not in the robot's mode"
            yield f"{mode.value} reported", state._replace(mode=done.state.mode), words

    def _given(self, state, command, by, is_spoken, heard_in=None):
        """A command reaches the queue; spoken ones of the node only where it was heard."""
        if is_spoken and heard_in is None and command in MOTIONS:
            return
        what, name = self.queue(command, is_spoken), f"{command.phrase} by {by}"
        if what == "stop":
            yield self._tick(state, name, one(is_stopped=True))
        elif what == "at once":
            yield self._tick(state, name, one((Given(command),)))
            yield self._tick(state, f"{name} and a stop", one((Given(command),), True))
        elif what == "queued" and state.pending is None:
            yield name, state._replace(pending=Waiting(command, is_spoken, heard_in)), ""

    def _verification(self, state):
        pending = state.pending
        if pending is None:
            return
        if not pending.is_verifying:
            is_refused = self.refused(state.controller, pending.command)
            next_one = None if is_refused else pending._replace(is_verifying=True, is_fresh=True)
            yield "verification begins", state._replace(pending=next_one), ""
            return
        yield "verification refuses", state._replace(pending=None), ""
        given = (Given(pending.command, pending.is_spoken, pending.is_fresh),)
        for is_recorded, is_stopped in product((True, False), (False, True)):
            if not self.passes(pending.command, is_recorded):
                continue
            name = "verified" + " unrecorded" * (not is_recorded) + ", and a stop" * is_stopped
            due = pending, is_recorded
            yield self._tick(state._replace(pending=None), name, one(given, is_stopped), *due)

    # What it leads to.

    def _tick(self, state, name, given, pending=None, is_recorded=True):
        to, edge = self.table[state.controller][given]
        waiting = state.pending
        if "stale" in edge.outcomes:
            waiting = pending._replace(is_verifying=False)
        elif waiting is not None and edge.has_changed and waiting.is_verifying:
            waiting = waiting._replace(is_fresh=False)
        is_stopped = given.is_stopped
        if state.is_stopped and not self._is_woken(state, given, edge):
            is_stopped = True
        after = state._replace(controller=to, pending=waiting, is_stopped=is_stopped)
        return name, after, self._objection(state, edge, after, pending, is_recorded)

    def _is_woken(self, state, given, edge):
        """A "hey robot" was accepted, at once or after it had to wait for the robot."""
        if given.orders and given.orders[0].command is COMMANDS["hey robot"]:
            return "accepted" in edge.outcomes
        was_waiting, waits = not self.keys[state.controller][-1], not edge.to[-1]
        return was_waiting and not waits and edge.to[0] is State.ACTIVE

    def _objection(self, before, edge, after, pending, is_recorded):
        started = edge.started
        if after.is_stopped and edge.to[0] is State.MOVING:
            return 'it moves after a stop without "hey robot"'
        if after.is_stopped and not is_latched(edge.to[0], edge.to[2]):
            return 'a stop is undone without "hey robot"'
        if started is None:
            return ""
        if pending is None or not (pending.is_verifying and pending.is_fresh):
            return "it moves by what was not verified in this situation"
        if self.refused(before.controller, started.command):
            return "it moves although the mode forbids it"
        if started.is_spoken and pending.heard_in is not Mode.ACTIVE:
            return "it moves by a word that was heard in standby"
        if not is_recorded and started.command.load is Load.LOADS and self.on_loss != "ignore":
            return "it advances unrecorded"
        return ""

    # The product's rules, asked once for each case.

    def _hear(self, text, mode):
        state = dialogue.DialogueState(mode, "")
        outcome = self._mapper(text)
        if not isinstance(outcome, Match):
            return dialogue.DialogueStep(state, (), outcome.rejection)
        return dialogue.step(state, dialogue.CommandRecognized(SPOKEN.get(outcome.command)))

    def _report(self, mode, reported):
        state = dialogue.DialogueState(mode, "")
        return dialogue.step(state, dialogue.ModeReported(reported))

    def _queue(self, command, is_spoken):
        posted = _Posted()
        queue = command_queue.CommandQueue(posted, lambda *_: None, lambda: 0.0)
        queue.take(command.phrase, "test", is_spoken, is_by_hand=not is_spoken)
        if posted.stops:
            return "stop"
        if posted.orders:
            return "at once"
        return "queued" if queue.next(0.0) is not None else "refused"

    def _view(self, controller):
        """As the controller would show it now."""
        return self.graph.example[self.keys[controller]].executor._take_snapshot()

    def _refused(self, controller, command):
        """Whether verification's own check of the mode refuses a command."""
        return mode_refusal(command, self._view(controller).mode) is not None

    def _passes(self, command, is_recorded):
        """Whether the queue posts what was planned, as far as the recording goes."""
        posted = _Posted()
        watch = _watch(self.on_loss, is_recorded)
        verify: Any = RecordedOnly(lambda *_: Accepted(plan_of(command)), watch)
        queue = command_queue.CommandQueue(posted, verify, lambda: 0.0)
        queue.take(command.phrase, "test")
        queue.check(queue.next(0.0))
        return bool(posted.orders)

    def _must_stop(self, controller):
        """Whether what moves has to brake while nobody records it."""
        view, watch = self._view(controller), _watch(self.on_loss, False)
        return view.mode.state is State.MOVING and bool(watch.stop_cause(view.plan))
