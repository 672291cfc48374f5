# SPDX-License-Identifier: BSD-3-Clause
"""A new motion is one file and one row: "nudge" works from its words to the robot at rest."""

import numpy as np
import pytest

from rst_control.admission.command_queue import CommandQueue
from rst_control.admission.recording_gate import RecordedOnly, RecordingWatch
from rst_control.commands.parser import read_request
from rst_control.commands.spec import CommandSpec, Load, TissueNeeded
from rst_control.commands.table import COMMANDS, by_phrase, markdown
from rst_control.config.recording import RecordingConfig
from rst_control.kinematics.configuration import Configuration
from rst_control.planning.plan import PhaseKind
from rst_control.types import Reason, State
from tests.unit.rst_control.support import nudge
from tests.unit.rst_control.support.executor_rig import Rig, shared

ROW = CommandSpec(
    "nudge",
    "goes in along the shaft by 2 mm and back",
    load=Load.LOADS,
    tissue=TissueNeeded.NONE,
    phases=(PhaseKind.INSERT, PhaseKind.WITHDRAW),
    plan=nudge.plan,
)
TABLE = by_phrase((*COMMANDS.values(), ROW))


class NudgeRig(Rig):
    """The controller with one row more in its table of commands."""

    def __init__(self):
        super().__init__()
        self.record(self.context.verify)

    def record(self, verify):
        self.queue = CommandQueue(self.executor, verify, lambda: self.now, TABLE)


@pytest.fixture
def rig():
    return NudgeRig()


def test_its_words_are_read():
    assert read_request("  NUDGE ", commands=TABLE).command is ROW


def test_in_standby_it_is_refused_with_the_way_on(rig):
    assert rig.run(0.01).refused("nudge") == 'in standby; say "hey robot" first'
    assert rig.view.last_refusal.reason is Reason.WRONG_MODE


def test_its_plan_keeps_the_shaft_in_the_trocar_and_ends_where_it_began(rig):
    rig.awake()
    situation = rig.view.situation(rig.now)
    plan = rig.context.verify(read_request("nudge", commands=TABLE), situation).plan
    planner = shared()[2].planner
    paths = [phase.path for phase in plan.phases]
    assert [phase.kind for phase in plan.phases] == list(ROW.phases)
    for path in paths:
        samples = path.sample(planner.model.chain, planner.trocar)
        assert samples.rcm_error.max() < rig.config.rcm.planned_tolerance
    there, back = (Configuration(planner.model, path.end).tip for path in paths)
    start = Configuration(planner.model, paths[0].start).tip
    assert np.linalg.norm(there - start) == pytest.approx(nudge.LENGTH, abs=1e-7)
    np.testing.assert_allclose(back, start, atol=1e-9)


def test_it_is_carried_out_to_its_end(rig):
    pending = rig.awake().say("nudge")
    assert pending.reply.result(0).message == "goes in by 2 mm and back"
    assert rig.worst_error_until(pending.ended.done) < 1e-6
    assert pending.ended.result(0).kind == "succeeded"
    assert rig.state is State.ACTIVE and rig.view.command == "nudge"


def test_a_stop_in_the_middle_brakes_on_its_path_and_latches(rig):
    rig.awake().say("nudge")
    rig.until(lambda: rig.phase == "insert" and rig.view.motion.progress > 0.4)
    rig.give("stop")
    assert rig.worst_error_until(lambda: rig.state is State.HALTED) < 1e-6
    assert 0.4 < rig.view.path_position / rig.view.path.length < 1.0
    assert rig.still_for(0.1) and "halted" in rig.refused("nudge")


def test_while_another_motion_runs_or_tissue_is_held_it_is_refused(rig):
    rig.awake().say("nudge")
    rig.run(0.02)
    assert "busy" in rig.refused("nudge")
    rig.until(lambda: rig.state is State.ACTIVE)
    rig.finish("tense")
    assert "release first" in rig.refused("nudge")
    assert rig.view.last_refusal.reason is Reason.ALREADY_GRASPED


def test_without_a_recording_it_is_refused_as_all_that_loads_the_patient(rig):
    watch = RecordingWatch(RecordingConfig(on_loss="refuse", heartbeat_age=2.0), lambda: rig.now)
    rig.awake().record(RecordedOnly(rig.context.verify, watch))
    assert rig.refused("nudge").startswith("not recorded")


def test_it_is_listed_in_the_reply_to_unknown_words_and_in_the_documents_table(rig):
    assert rig.awake().refused("dance").endswith("look wider, nudge")
    row = markdown(TABLE).splitlines()[-1]
    assert row.startswith("| nudge | by voice or hand | active |")
    assert "nothing held" in row and ROW.does in row
