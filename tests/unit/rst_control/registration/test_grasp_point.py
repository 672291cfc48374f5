# SPDX-License-Identifier: BSD-3-Clause
"""Setting the grasp point: where the sheet can be taken and pulled, at rest, in one tick."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rst_control.registration.grasp_point import GraspPointRegistrar
from rst_control.registration.trocar import TrocarRegistrar
from rst_control.registration.trocar_context import TrocarContext
from rst_control.tissue.sheet import rest_points
from rst_control.types import State
from tests.unit.rst_control.support.executor_rig import Rig
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


@pytest.mark.parametrize("aside", [-0.008, 0.008])
def test_tense_takes_the_tissue_at_the_point_that_was_set(aside):
    here = setting()
    point = here.node(aside=aside)
    assert "grasp point (" in here.accepted(point)
    entry = here.rig.executor.events[-1]
    assert entry.kind == "grasp_set" and "was (0.468000, -0.024000, 0.269000) m" in entry.message
    planner = here.rig.context.current.planner
    np.testing.assert_allclose(planner.T_base_grasp[:3, 3], point)


def test_setting_moves_nothing_and_keeps_a_latch():
    here = setting()
    here.rig.say("stop")
    here.accepted(here.node(aside=0.008))
    assert here.rig.still_for(0.3) and here.rig.state is State.HALTED


def test_beside_the_tissue_it_is_refused():
    here = setting()
    assert "mm from a node" in here.refused(here.first + np.array([0.0, 0.02, 0.0]))
    assert "mm from a node" in here.refused(here.first + np.array([0.0, 0.0, 0.01]))


def test_deep_inside_the_sheet_it_is_refused():
    here = setting()
    assert "inside the nearest free edge" in here.refused(here.node(down=0.030))


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_what_is_no_number_is_refused(bad):
    here = setting()
    assert "no finite number" in here.refused([bad, 0.0, 0.3])


def test_where_a_limit_would_be_broken_it_is_refused_with_the_limit():
    here = setting()
    current = here.rig.context.current
    scene = replace(current.config.scene, workspace_radius=0.034)  # just about the first point
    here.rig.context.current = TrocarContext(replace(current.config, scene=scene), current.model)
    message = here.refused(here.node(aside=0.04))
    assert "cannot be taken there" in message and "workspace" in message


@pytest.mark.parametrize("phase", ["reach", "pull"])
def test_while_moving_it_is_refused(phase):
    here = setting(Rig().moving(phase))
    assert here.refused(here.node(aside=0.008)) == "moving; wait until the robot is at rest"


def test_what_was_planned_on_another_trocar_is_not_set():
    here = setting()
    trocar = TrocarRegistrar(here.rig.context, here.rig.executor)
    first = trocar.ask(here.rig.context.current.trocar + 1e-4, "/other")
    second = here.registrar.ask(here.node(aside=0.008), "/test")
    here.rig.tick()
    here.rig.tick()
    assert first.result(0).accepted
    assert not second.result(0).accepted
    assert "set meanwhile" in second.result(0).message
