# SPDX-License-Identifier: BSD-3-Clause
"""Every reason that the controller knows has its own next step; checked against its code."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rst_control.execution.motion import OffPath
from rst_control.execution.phase_execution import _grip_failure
from rst_control.host.processes import ENDED
from rst_control.planning.patient_surface import TrocarPose
from rst_control.planning.plan import PhaseKind
from rst_control.supervision.presence import MASTER
from rst_control.supervision.watchdogs import Watched
from rst_control.tension.response_check import PullAnswer
from rst_control.types import Measurement, Reason
from tests.unit.rst_control.support.executor_rig import Rig
from tests.unit.voice_assist.audio.test_input_check import DEAFENING, LONG, objections
from tests.unit.voice_assist.support import alarm_words
from voice_assist.alarms.causes import (
    GIVE_UPS,
    LATCHES,
    NO_REASON,
    PARTS,
    REFUSALS,
    UNHEARD,
    UNKNOWN,
    find,
)
from voice_assist.alarms.types import Kind
from voice_assist.audio.corruption import damage
from voice_assist.config import load_voice_config
from voice_assist.intent.dialogue import Heard, State, step
from voice_assist.types import Mode

TABLES = (LATCHES, GIVE_UPS, REFUSALS, UNHEARD, PARTS)
SAME_WORDS = {  # one text for two reasons with one next step, or a next step of its own
    "faulted": {"halted"},
    "not connected": {"no master"},
}
WRAPPED = ("cannot ", "measured: 0.5", "0.5;")  # round an error of planning, see below
REJECTED = sorted(r for r in set(alarm_words.rejected()) if not r[1].startswith(WRAPPED))
INSIDE = TrocarPose(error=1e-6, insertion=0.12, wrist=0.09, height=-0.13, is_outside=False)
GOOD = Watched(
    setpoint=np.zeros(10),
    trocar_pose=INSIDE,
    raises_tension=True,
    needs_grip=False,
    overtime=0.1,
    heartbeat_age=None,
)


def measured(**changes):
    zeros = np.zeros(10)
    return replace(Measurement(position=zeros, velocity=zeros, effort=zeros, stamp=0.0), **changes)


def latch_words():
    """What the real watchdogs say, of everything that they look at."""
    dogs = Rig().executor._watchdogs
    off = replace(GOOD, trocar_pose=replace(INSIDE, error=2e-3))
    fault = "set-points stopped coming while moving, 31 ms ago"
    return {
        "not connected": dogs.motion(0.0, None, GOOD),
        "stale": dogs.motion(0.5, measured(), GOOD),
        "set-points stopped": dogs.motion(0.0, measured(fault=fault), GOOD),
        "robot fault": dogs.motion(0.0, measured(fault="brakes on"), GOOD),
        "tension sensor": dogs.motion(0.0, measured(fault="tension is not measured"), GOOD),
        "joint messages": dogs.motion(0.0, measured(fault="joint states cut short"), GOOD),
        "off its set-point": dogs.motion(0.0, measured(position=np.eye(10)[3] * 0.06), GOOD),
        "off the trocar": dogs.motion(0.0, measured(), off),
        "over tension": dogs.motion(0.0, measured(force=np.array([0.0, 0.0, -2.5])), GOOD),
        "slipped": dogs.motion(0.0, measured(), replace(GOOD, needs_grip=True)),
        "voice silent": dogs.motion(0.0, measured(), replace(GOOD, heartbeat_age=0.9)),
        "overtime": dogs.motion(0.0, measured(), replace(GOOD, overtime=1e3)),
        "node lost": lost("/panel", replace(GOOD, owner="/panel")),
        "no master": lost(MASTER, GOOD),
    }


def lost(who, watched):
    """What the watchdogs say when somebody has ended."""
    rig = Rig()
    rig.presence.report({who: ENDED})
    return rig.executor._watchdogs.motion(0.0, measured(), watched)


def test_every_watchdog_and_every_stop_has_its_own_next_step():
    for name, words in latch_words().items():
        assert find(LATCHES, words, UNKNOWN).name == name, words


def test_every_stop_that_the_code_can_ask_for_is_known():
    found = sorted(set(alarm_words.stops()))
    assert len(found) >= 4, found
    for words in found:
        assert find(LATCHES, words, UNKNOWN).kind is Kind.STOP, words


def test_a_lost_recording_that_stops_is_a_fault_and_no_persons_stop():
    cause = find(LATCHES, "not recorded: recorder silent for 1.2 s, allowed 1.0 s", UNKNOWN)
    assert cause.kind is Kind.FAULT and "recorder" in cause.next_step


def test_the_controllers_own_error_is_known():
    rig = Rig().moving("reach")
    rig.executor.crashed(ArithmeticError("not a number"))
    assert find(LATCHES, rig.executor._mode.reason, UNKNOWN).name == "loop error"


def test_every_reason_of_verification_has_a_next_step():
    assert {reason.value for reason in Reason} <= {cause.name for cause in REFUSALS}


@pytest.mark.parametrize(("reason", "words"), REJECTED)
def test_the_words_of_each_refusal_lead_to_the_next_step_of_its_reason(reason, words):
    wanted = Reason[reason].value
    name = find(REFUSALS, words, NO_REASON).name
    assert name == wanted or name in SAME_WORDS.get(wanted, ()) or name == "sensor fault", words


def test_the_search_for_refusals_finds_what_is_there():
    found = {name for name, _ in REJECTED}
    assert {"BUSY", "HALTED", "STALE", "WRONG_MODE", "TENSION_LIMIT", "NOT_INSERTED"} <= found


@pytest.mark.parametrize("case", alarm_words.infeasible(), ids=lambda case: case[0].__name__)
def test_the_words_of_each_error_of_planning_lead_to_its_reason(case):
    kind, wanted, words = case
    name = find(REFUSALS, words, NO_REASON).name
    special = {"NoGrasp": "no grasp", "NoWay": "collision", "ToolBent": "unreachable"}
    assert name == special.get(kind.__name__, wanted), words


def test_every_refusal_at_the_desk_is_known():
    found = sorted(set(alarm_words.desk_refusals()))
    assert len(found) >= 5, found
    for words in found:
        assert find(REFUSALS, words, NO_REASON) is not NO_REASON, words


def test_a_motion_that_would_begin_elsewhere_is_known():
    words = str(OffPath(PhaseKind.REACH, 0.1))
    assert find(REFUSALS, words, NO_REASON).name == "not at rest"


def give_ups():
    answer = PullAnswer()
    for s, tension in ((1e-3, 0.4), (2e-3, 0.4), (3e-3, 0.4)):
        answer.look(s, tension)
    return (
        answer.objection,
        _grip_failure(PhaseKind.CLOSE, False),
        _grip_failure(PhaseKind.ALIGN, True),
    )


def test_every_way_to_give_a_motion_up_is_known():
    assert [find(GIVE_UPS, words, UNKNOWN) for words in give_ups()] == list(GIVE_UPS)


def test_commands_that_the_mode_forbids_are_known():
    commands = load_voice_config().commands
    why = step(State(Mode.STANDBY, "start"), Heard(commands.get("tense"))).rejection.words
    assert find(UNHEARD, why, NO_REASON).name == "wrong mode"


def test_every_next_step_is_a_short_sentence_that_asks_for_something():
    for cause in (*(c for table in TABLES for c in table), UNKNOWN, NO_REASON):
        step_words = cause.next_step
        assert 10 <= len(step_words) <= 80 and step_words[0].isupper(), step_words
        assert step_words.endswith("."), step_words


@pytest.mark.parametrize("table", TABLES)
def test_no_cause_stands_twice_and_none_hides_behind_another(table):
    names = [cause.name for cause in table]
    assert len(set(names)) == len(names)


def test_words_that_nobody_foresaw_get_the_general_next_step():
    assert find(LATCHES, "the moon fell down", UNKNOWN) is UNKNOWN
    assert find(REFUSALS, "because it is Tuesday", NO_REASON) is NO_REASON


def test_bad_sound_is_told_with_what_to_do_about_it():
    muted, deafened = (objections(s)[-1] for s in (np.zeros(LONG), DEAFENING))
    assert find(PARTS, f"voice: {muted}", UNKNOWN).name == "voice muted"
    assert find(PARTS, f"voice: {deafened}", UNKNOWN).name == "voice overloaded"
    broken = damage(np.random.default_rng(1).uniform(-1.0, 1.0, 16_000).astype(np.float32))
    assert find(UNHEARD, broken, NO_REASON).name == "damaged sound"
