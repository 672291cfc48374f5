# SPDX-License-Identifier: BSD-3-Clause
"""Setting the grasp point: where the sheet can be taken and pulled, at rest, in one tick."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from rst_control.admission.command_queue import CommandQueue
from rst_control.registration.grasp_point import GraspHere, GraspPointRegistrar
from rst_control.registration.tracked_grasp import TrackedGrasp
from rst_control.registration.tracked_place import Report
from rst_control.registration.trocar import TrocarRegistrar
from rst_control.registration.trocar_context import TrocarContext
from rst_control.tissue.sheet import rest_points
from rst_control.types import State
from tests.unit.rst_control.support.executor_rig import PERIOD, Rig
from tests.unit.rst_control.support.registration import Setting


class GraspSetting(Setting):
    """A rig with somebody who sets its grasp point."""

    refusal = ("grasp_refused", "set_grasp_point")

    def __init__(self, rig):
        super().__init__(rig, GraspPointRegistrar)
        self.first = np.array(self.scene.grasp_point)
        self.nodes = rest_points(self.scene.tissue)

    @property
    def scene(self):
        return self.rig.context.current.config.scene

    @property
    def point(self):
        return self.scene.grasp_point

    def node(self, aside=0.0, down=0.0):
        """The node nearest to a place beside the first grasp point along the edge, and below."""
        near = self.first + np.array([aside, 0.0, -down])
        return self.nodes[np.linalg.norm(self.nodes - near, axis=1).argmin()]


def setting(rig=None):
    return GraspSetting(rig or Rig().awake())


@pytest.fixture
def here():
    return setting()


@pytest.mark.parametrize("aside", [-0.008, 0.008])
def test_tense_takes_the_tissue_at_the_point_that_was_set(here, aside):
    point = here.node(aside=aside)
    assert "grasp point (" in here.accepted(point)
    entry = here.rig.executor.events[-1]
    assert entry.kind == "grasp_set" and "was (0.468000, -0.024000, 0.269000) m" in entry.message
    planner = here.rig.context.current.planner
    np.testing.assert_allclose(planner.grasp_candidates[0].T_base_tip[:3, 3], point)


def test_setting_moves_nothing_and_keeps_a_latch(here):
    here.rig.say("stop")
    here.accepted(here.node(aside=0.008))
    assert here.rig.still_for(0.3) and here.rig.state is State.HALTED


def test_beside_the_tissue_it_is_refused(here):
    assert "mm from a node" in here.refused(here.first + np.array([0.0, 0.02, 0.0]))
    assert "mm from a node" in here.refused(here.first + np.array([0.0, 0.0, 0.01]))


def test_deep_inside_the_sheet_it_is_refused(here):
    assert "inside the nearest free edge" in here.refused(here.node(down=0.030))


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_what_is_no_number_is_refused(here, bad):
    found = f"coordinates [{bad}, 0.0, 0.3] m, allowed: finite numbers"
    assert found in here.refused([bad, 0.0, 0.3])


def test_where_a_limit_would_be_broken_it_is_refused_with_the_limit(here):
    current = here.rig.context.current
    scene = replace(current.config.scene, workspace_radius=0.034)  # just about the first point
    here.rig.context.current = TrocarContext(replace(current.config, scene=scene), current.model)
    message = here.refused(here.node(aside=0.04))
    assert "cannot be taken there" in message and "workspace" in message


@pytest.mark.parametrize("phase", ["reach", "pull"])
def test_while_moving_it_is_refused(phase):
    here = setting(Rig().moving(phase))
    assert here.refused(here.node(aside=0.008)) == "moving; wait until the robot is at rest"


def test_what_was_planned_on_another_trocar_is_not_set(here):
    trocar = TrocarRegistrar(here.rig.context, here.rig.executor)
    first = trocar.ask(here.rig.context.current.trocar + 1e-4, "/other")
    second = here.registrar.ask(here.node(aside=0.008), "/test")
    here.rig.tick()
    here.rig.tick()
    assert first.result(0).accepted
    assert not second.result(0).accepted
    assert "set meanwhile" in second.result(0).message


def test_the_way_of_the_pull_is_set_with_the_point(here):
    point = here.node(aside=0.008)
    reply = here.ask([*point, 0.2, 0.0, 2.0])
    assert reply.accepted and "pulled along (0.100, 0.000, 0.995)" in reply.message
    np.testing.assert_allclose(here.point, point)
    assert here.scene.pull_direction == (0.2, 0.0, 2.0)
    pull = here.rig.context.current.planner.grasp_candidates[0].pull
    np.testing.assert_allclose(pull, np.array([0.2, 0.0, 2.0]) / np.hypot(0.2, 2.0))


@pytest.mark.parametrize("pull", [(0.0, 0.0, 0.0), (np.nan, 0.0, 1.0)])
def test_a_way_of_the_pull_that_is_none_is_refused(here, pull):
    assert "pull direction" in here.refused([*here.node(aside=0.008), *pull])


def test_who_set_it_and_when_is_known(here):
    assert here.rig.context.grasp_origin.source == "scene.yaml"
    here.rig.run(1.0)
    here.accepted(here.node(aside=0.008))
    origin = here.rig.context.grasp_origin
    assert origin.source == "/test" and origin.stamp == pytest.approx(here.rig.now, abs=0.01)
    assert here.rig.context.trocar_origin.source == "scene.yaml"
    here.refused(here.first + np.array([0.0, 0.02, 0.0]))
    assert here.rig.context.grasp_origin is origin


# "grasp here": the tip shows the point.


def shown_by_tip(here):
    """Let its queue take "grasp here"."""
    verify = GraspHere(here.rig.context.verify, here.registrar)
    here.rig.queue = CommandQueue(here.rig.executor, verify, lambda: here.rig.now)
    return here


def touching(aside=0.008):
    """A rig whose tip is at a node beside the grasp point, its jaws closed on nothing."""
    here = setting(Rig())
    planner = here.rig.context.current.planner
    goal = planner.grasp_candidates[0].T_base_tip.copy()
    goal[:3, 3] = here.node(aside=aside)
    *_, path = planner.route(np.array(here.scene.home), goal)
    return shown_by_tip(setting(Rig(start=path.end).awake()))


def test_the_tip_shows_where_to_grasp():
    here = touching()
    pending = here.rig.say("grasp here")
    assert pending.ended.result(0).kind == "succeeded"
    np.testing.assert_allclose(here.point, here.node(aside=0.008), atol=1e-5)
    assert here.rig.context.grasp_origin.source == "test"
    kinds = here.rig.event_kinds()
    assert kinds.index("grasp_set") < len(kinds) and "accepted" in kinds
    assert here.rig.still_for(0.2)


def test_shown_where_no_tissue_is_it_is_refused():
    here = shown_by_tip(setting())
    before = here.point
    assert "mm from a node" in here.rig.refused("grasp here")
    assert here.point == before


def test_shown_while_tissue_is_held_it_is_refused(here):
    here.rig.finish("tense")
    assert "release first" in here.rig.refused("grasp here")


def test_shown_in_motion_it_is_refused():
    here = setting(Rig().moving("reach"))
    assert "busy moving" in here.rig.refused("grasp here")


def test_it_is_given_by_hand_never_by_voice():
    here = touching()
    assert "by hand" in here.rig.refused("grasp here", spoken=True)


# A tracker shows it.


def follower(here, is_taken=True):
    tracking = here.rig.config.controller.tracking
    tracking = replace(tracking, grasp_point=replace(tracking.grasp_point, is_taken=is_taken))
    return TrackedGrasp(tracking, here.rig.context, here.registrar)


def reported(here, grasp, point, seconds=0.7, pull=()):
    """Track a point for a while; returns the answers of what was asked for."""
    answers = []
    for number in range(round(seconds / PERIOD)):
        if number % 10 == 0:
            grasp.update(Report(np.array(point), here.rig.now, pull))
            answers.append(grasp.step(here.rig.now, "/tracker"))
        here.rig.tick()
    return [answer.result(0) for answer in answers if answer is not None]


def test_a_tracked_point_is_set_once_it_is_steady(here):
    point = here.node(aside=0.008)
    (reply,) = reported(here, follower(here), point, pull=(0.0, 0.0, 1.0))
    assert reply.accepted, reply.message
    np.testing.assert_allclose(here.point, point, atol=1e-9)
    assert here.rig.context.grasp_origin.source == "/tracker"
    assert here.scene.pull_direction == (0.0, 0.0, 1.0)


def test_a_refusal_is_reported_once_and_holds_until_the_situation_changes(here):
    beside = here.first + np.array([0.0, 0.02, 0.0])
    grasp = follower(here)
    (reply,) = reported(here, grasp, beside)
    assert not reply.accepted and "from a node" in reply.message
    assert "from a node" in grasp.objection(here.rig.now).words
    here.rig.say("stop")
    here.rig.run(0.3)
    here.rig.say("hey robot")
    here.rig.run(0.3)
    (again,) = reported(here, grasp, beside)
    assert not again.accepted


def test_a_refusal_that_passes_by_itself_is_not_the_last_word(here):
    """The robot trembled in the tick that was to take the point."""
    point, grasp = here.node(aside=0.008), follower(here)
    measured_js, ask, ticks = here.rig.robot.measured_js, here.registrar.ask, []

    def ask_before_a_tremble(*given):
        ticks.append(0.02 if not ticks else 0.0)
        return ask(*given)

    def measured():
        found, speed = measured_js(), ticks[0] if ticks else 0.0
        ticks[:1] = [0.0] if ticks else []
        return replace(found, velocity=found.velocity + speed)

    here.rig.robot.measured_js, here.registrar.ask = measured, ask_before_a_tremble
    first, again = reported(here, grasp, point)
    assert not first.accepted and "not at rest" in first.message
    assert again.accepted, again.message
    np.testing.assert_allclose(here.point, point, atol=1e-9)


def test_a_refusal_is_reported_no_longer_once_the_point_is_active_by_another_way(here, monkeypatch):
    beside = here.first + np.array([0.0, 0.02, 0.0])
    grasp = follower(here)
    reported(here, grasp, beside)
    assert grasp.objection(here.rig.now) is not None
    scene = replace(here.scene, grasp_point=tuple(beside))
    current = SimpleNamespace(config=SimpleNamespace(scene=scene))
    monkeypatch.setattr(grasp, "_present", SimpleNamespace(current=current))
    assert grasp.objection(here.rig.now) is None


def test_a_point_that_a_person_sets_after_the_tracked_one_stays(here):
    grasp, point, other = follower(here), here.node(aside=0.008), here.node(aside=0.004)
    (reply,) = reported(here, grasp, point)
    assert reply.accepted, reply.message
    here.accepted(other)
    assert reported(here, grasp, point) == []
    np.testing.assert_allclose(here.point, other, atol=1e-9)


def test_another_way_of_the_pull_alone_is_taken(here):
    grasp, point = follower(here), here.node(aside=0.008)
    for pull in ((0.0, 0.0, 1.0), (-0.3, 0.0, 1.0)):
        (reply,) = reported(here, grasp, point, pull=pull)
        assert reply.accepted, reply.message
        assert here.scene.pull_direction == pull
    assert reported(here, grasp, point, pull=(-0.3, 0.0, 1.0)) == []


@pytest.mark.parametrize("phase", ["reach", "pull"])
def test_in_motion_a_tracked_point_is_not_asked_for(phase):
    here = setting(Rig().moving(phase))
    assert reported(here, follower(here), here.node(aside=0.008), seconds=0.1) == []


def test_a_tracked_point_is_only_watched_unless_it_is_to_be_taken(here):
    assert reported(here, follower(here, is_taken=False), here.node(aside=0.008)) == []


def test_near_the_point_that_counts_nothing_is_set(here):
    assert reported(here, follower(here), here.first + 4e-4) == []


def test_the_range_counts_from_the_configured_point_also_where_another_was_kept(here):
    """A kept point is restored before the tracker is listened to."""
    kept, limit = here.node(aside=0.008), here.rig.config.controller.tracking.grasp_point.range
    here.accepted(kept)
    for aside, is_within in ((-limit + 0.004, True), (limit + 0.004, False)):
        grasp = follower(here)
        grasp.update(Report(here.first + np.array([aside, 0.0, 0.0]), here.rig.now))
        assert ("place tracked for 0.00 s" in grasp.objection(here.rig.now).words) == is_within
