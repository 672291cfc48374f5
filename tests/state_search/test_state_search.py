# SPDX-License-Identifier: BSD-3-Clause
"""No sequence of events leads to motion that it must not lead to, however long it is.

The real executor is explored to the fixed point (`searched_controller`), then dialogue, queue and
recording together with it (`searched_system`). No new state is found beyond the depth that is
asserted here, so what holds for all sequences up to it holds for every longer one, too.
"""

import copy
import random

import pytest

from rst_control.admission.recording_gate import RecordingWatch
from rst_control.commands.camera_step import CAMERA_STEPS
from rst_control.commands.preconditions import mode_refusal
from rst_control.commands.spec import Role
from rst_control.commands.table import COMMANDS
from rst_control.execution import executor, state_machine
from rst_control.execution.executor import Executor
from rst_control.execution.motion import Motion
from rst_control.supervision.watchdogs import Watchdogs
from rst_control.types import ControllerMode, State
from tests.state_search.controller import Controller, explore
from tests.state_search.inputs import AT_ONCE, FOUND, MOTIONS, Given, inputs, one
from tests.state_search.system import SPOKEN, Search
from voice_assist.intent import dialogue
from voice_assist.types import Mode

pytestmark = pytest.mark.timeout(1800)  # some ten seconds of processor time, however busy it is
DEPTH = 8  # of the sequences that were asked for
SAMPLE = 150  # edges, for which a state is compared with one that looks like it


@pytest.fixture(scope="module")
def graph():
    return explore()


@pytest.fixture(scope="module", params=["refuse", "stop"])
def search(graph, request):
    return Search(graph, request.param).run()


def shortest_ways(objections):
    """The shortest way to each, for people."""
    return {words: " ; ".join(map(str, way)) for words, way in reversed(objections)}


def test_every_command_and_every_state_is_in_the_search(graph):
    tried = {order.command for given in inputs() for order in given.orders}
    assert tried | {COMMANDS["stop"], *CAMERA_STEPS} == set(COMMANDS.values()) and tried & set(
        CAMERA_STEPS
    )
    assert {key[0] for key in graph.edges} == set(State)
    assert all(len(edges) == len(inputs()) for edges in graph.edges.values())


def test_no_sequence_of_events_breaks_an_invariant_of_the_controller(graph):
    assert shortest_ways(graph.objections) == {}
    assert 50 < len(graph.edges) < 1000 and graph.depth <= DEPTH


def test_no_sequence_through_dialogue_queue_and_recording_moves_what_must_not_move(search):
    assert shortest_ways(search.objections) == {}
    assert len(search.found) > 1000 and search.transitions > 50_000


def test_the_search_does_move_by_every_command_and_wakes_and_brakes(search):
    """What is never reached would be no proof."""
    started, states = set(), set()
    for state in search.found:
        states.add(search.keys[state.controller][0])
        pending = state.pending
        if pending is not None and pending.is_verifying and pending.is_fresh:
            given = one((Given(pending.command, pending.is_spoken),))
            started.add(search.table[state.controller][given][1].started)
    assert states == set(State)
    assert {(s.command, s.is_spoken) for s in started if s is not None} == {
        *((c, False) for c in MOTIONS if c.role is not Role.SET_UP),
        *(
            (c, True) for c in MOTIONS if not c.is_by_hand_only and c not in CAMERA_STEPS
        ),  # as in commands.yaml
    }


def test_states_that_look_alike_go_on_alike(graph):
    """Two ways into one state: whatever comes next leads both to the same."""
    rng, given = random.Random(5), inputs()
    keys = list(graph.edges)
    for _ in range(SAMPLE):
        key, step = rng.choice(keys), rng.choice(given)
        twin = graph.example[key].fork()
        twin.take(step)
        for after in rng.sample(given, 4):
            edge = twin.fork().take(after)
            known = graph.edges[twin.key()][after]
            assert edge == known, (key, str(step), str(after))


def test_a_fork_leaves_its_original_as_it_was():
    first = Controller()
    for step in (one((Given(COMMANDS["hey robot"]),)), one((Given(COMMANDS["tense"]),))):
        first.take(step)
    before = first.key(), copy.copy(first.executor._setpoint_state.held)
    terminated = one((Given(COMMANDS["terminate"]),))
    for step in (one(is_stopped=True), one(found="arrived"), terminated):
        first.fork().take(step)
    assert (first.key(), first.executor._setpoint_state.held.tolist()) == (
        before[0],
        before[1].tolist(),
    )


def test_what_is_given_by_hand_only_is_refused_from_the_voice(graph):
    queue = Search(graph).queue
    assert {queue(command, True) for command in MOTIONS if command.is_by_hand_only} == {"refused"}


def test_the_voice_mode_depends_on_nothing_but_the_mode_and_the_word():
    reasons = ("start", *SPOKEN.phrases, "tense, refused by the robot: x")
    for mode in Mode:
        for config in SPOKEN.commands:
            steps = [
                dialogue.step(dialogue.DialogueState(mode, why), dialogue.CommandRecognized(config))
                for why in reasons
            ]
            assert len({(done.state.mode, done.actions) for done in steps}) == 1
            for why, accepted in ((why, a) for why in reasons for a in (True, False)):
                answer = dialogue.Answered(config.phrase, accepted, "x")
                assert dialogue.step(dialogue.DialogueState(mode, why), answer).state.mode is mode


# Rules that are broken on purpose: the search must find each of them.


def motion_while_halted(patch):
    lax = lambda command, mode: None if command in MOTIONS else mode_refusal(command, mode)  # noqa: E731
    patch.setattr(executor, "mode_refusal", lax)
    patch.setattr(
        state_machine, "started", lambda mode: ControllerMode(State.MOVING, mode.is_active)
    )


def a_stop_that_is_forgotten_while_braking(patch):
    stopped = state_machine.stopped
    forgetful = lambda mode, reason: (  # noqa: E731
        mode if mode.state is State.STOPPING else stopped(mode, reason)
    )
    patch.setattr(state_machine, "stopped", forgetful)


def braking_that_leads_to_active(patch):
    patch.setattr(
        state_machine, "at_rest", lambda mode: ControllerMode(State.ACTIVE, mode.is_active)
    )


def a_path_verified_elsewhere(patch):
    patch.setattr(Executor, "_serial", property(lambda self: 0))


def a_watchdog_that_sleeps(patch):
    patch.setattr(Executor, "_watch", lambda self, motion: None)


def a_set_point_that_creeps_at_rest(patch):
    def creep(self, measured, held):
        if held is not None:
            self._setpoint_state.held = held + 1e-9

    patch.setattr(Executor, "_keep_still", creep)


def hey_robot_that_outlives_a_stop(patch):
    patch.setattr(Executor, "_outrun", lambda self, order: None)


def motion_that_does_not_brake(patch):
    patch.setattr(state_machine, "stopped", lambda mode, reason: mode)
    patch.setattr(Motion, "brake", lambda self: None)


def a_lost_master_that_nobody_minds(patch):
    patch.setattr(Watchdogs, "master", lambda self: None)


def a_lost_owner_whom_nobody_minds(patch):
    patch.setattr(Watchdogs, "owner", lambda self, name: None)


CONTROLLER_FAULTS = (
    a_lost_master_that_nobody_minds,
    a_lost_owner_whom_nobody_minds,
    motion_while_halted,
    a_stop_that_is_forgotten_while_braking,
    braking_that_leads_to_active,
    a_path_verified_elsewhere,
    a_watchdog_that_sleeps,
    a_set_point_that_creeps_at_rest,
    hey_robot_that_outlives_a_stop,
    motion_that_does_not_brake,
)
FEW = [
    *(one(found=name) for name in FOUND),
    *(
        one((Given(c, is_fresh=fresh),))
        for c in (*AT_ONCE, COMMANDS["tense"])
        for fresh in (True, False)
    ),
    *(one(is_stopped=True), one((Given(COMMANDS["hey robot"]),), is_stopped=True)),
]


@pytest.mark.parametrize("fault", CONTROLLER_FAULTS)
def test_a_broken_rule_of_the_controller_is_found(fault, monkeypatch):
    fault(monkeypatch)
    assert explore(FEW, deepest=DEPTH, is_first_enough=True).objections


def test_the_few_inputs_find_nothing_where_no_rule_is_broken():
    assert shortest_ways(explore(FEW).objections) == {}


def a_recorder_nobody_asks_for(patch):
    patch.setattr(RecordingWatch, "refusal", lambda self, command: None)


def a_dialogue_that_hears_commands_in_standby(patch):
    step = dialogue.step
    awake = lambda state, event: step(dialogue.DialogueState(Mode.ACTIVE, state.reason), event)  # noqa: E731
    patch.setattr(dialogue, "step", awake)


def a_voice_that_keeps_a_mode_of_its_own(patch):
    patch.setattr(dialogue, "_reported", lambda state, mode: dialogue.DialogueStep(state, ()))


@pytest.mark.parametrize(
    "fault",
    [
        a_recorder_nobody_asks_for,
        a_dialogue_that_hears_commands_in_standby,
        a_voice_that_keeps_a_mode_of_its_own,
    ],
)
def test_a_broken_rule_around_the_controller_is_found(graph, fault, monkeypatch):
    fault(monkeypatch)
    assert Search(graph).run(DEPTH, is_first_enough=True).objections
