# SPDX-License-Identifier: BSD-3-Clause
"""The sheet of tissue: statics, dynamics, taking hold and letting go."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rst_control.config import load_simulation_config
from rst_control.simulation.mass_spring import MassSpringSheet, SheetMaterial
from rst_control.simulation.tissue import SimulatedTissue
from rst_control.tissue.sheet import rim_nodes

STEP = 1e-3
SCENE = load_simulation_config().scene
CONFIG = SCENE.tissue
GRASP = np.array(CONFIG.reference_point)
PULL = np.array(CONFIG.reference_pull)
ALONG = PULL / np.linalg.norm(PULL)


def tissue(**changes) -> SimulatedTissue:
    return SimulatedTissue(replace(CONFIG, **changes), STEP)


def pulled(
    sheet: SimulatedTissue, distance: float, speed: float = 0.02, settle: float = 0.5
) -> np.ndarray:
    """Grasp, pull at a speed, wait; force on the jaws."""
    assert sheet.grasp(GRASP)
    steps = max(int(distance / speed / STEP), 1)
    for k in range(steps):
        sheet.advance(GRASP + ALONG * distance * (k + 1) / steps)
    for _ in range(int(settle / STEP)):
        force = sheet.advance(GRASP + ALONG * distance)
    return force


@pytest.mark.parametrize("stiffness", [20.0, 100.0, 400.0, 1000.0])
def test_pull_at_the_reference_has_the_stiffness_asked_for(stiffness):
    distance = float(np.linalg.norm(PULL))
    force = pulled(tissue(stiffness=stiffness, bed_stiffness=0.0), distance)
    assert -force @ ALONG == pytest.approx(stiffness * distance, rel=0.01)


def test_force_grows_with_displacement_and_is_nearly_linear():
    distances = np.linspace(0.002, 0.02, 10)
    felt = np.array([-pulled(tissue(), d) @ ALONG for d in distances])
    assert (np.diff(felt) > 0.0).all()
    assert np.allclose(felt / distances / CONFIG.stiffness, 1.0, atol=0.25)


def test_force_opposes_the_pull():
    force = pulled(tissue(), 0.01)
    assert -force @ ALONG > 0.95 * np.linalg.norm(force)


def free_sheet(**changes) -> MassSpringSheet:
    """A sheet of 60 by 40 mm that nothing holds at its rim."""
    columns, rows = np.meshgrid(np.linspace(0.0, 0.06, 7), np.linspace(0.0, 0.04, 5), indexing="ij")
    points = np.stack([columns, rows, np.zeros((7, 5))], axis=-1).reshape(-1, 3)
    material = SheetMaterial(stiffness=200.0, mass=1e-4, damping=0.02, drag=0.0, bed=0.0)
    return MassSpringSheet(points, 7, 5, np.zeros(35, bool), replace(material, **changes))


def test_the_force_on_what_holds_a_node_is_the_change_of_momentum_of_all_others():
    sheet, held, rng = free_sheet(), 17, np.random.default_rng(4)
    others, target = np.arange(35) != held, sheet.home[17].copy()
    sheet.v[:] = rng.normal(0.0, 0.01, sheet.v.shape)
    steps = int(np.ceil(STEP / sheet.longest_step()))
    for _ in range(300):
        target += rng.normal(0.0, 2e-4, 3)
        before = sheet.material.mass * sheet.v[others].sum(axis=0)
        force = sheet.advance(STEP, steps, held, target)
        after = sheet.material.mass * sheet.v[others].sum(axis=0)
        assert np.allclose(after - before, -force * STEP, atol=1e-12)


def test_at_rest_the_bed_carries_the_pull():
    sheet, pull = free_sheet(bed=2.0, drag=50.0), np.array([0.0, 0.0, 0.005])
    steps = int(np.ceil(STEP / sheet.longest_step()))
    for share in np.linspace(0.0, 1.0, 200):
        sheet.advance(STEP, steps, 17, sheet.home[17] + share * pull)
    for _ in range(3000):
        force = sheet.advance(STEP, steps, 17, sheet.home[17] + pull)
    others = np.arange(35) != 17
    assert np.linalg.norm(force) > 0.03
    assert np.allclose(force, 2.0 * (sheet.home - sheet.x)[others].sum(axis=0), atol=1e-6)


def test_taking_hold_changes_no_force():
    sheet = tissue()
    assert sheet.grasp(GRASP + np.array([0.001, 0.0005, -0.001]))
    assert np.linalg.norm(sheet.advance(GRASP + np.array([0.001, 0.0005, -0.001]))) < 1e-9


def test_release_drops_the_force_to_zero_at_once_and_the_sheet_comes_back():
    sheet = tissue()
    pulled(sheet, 0.015)
    sheet.release()
    assert not sheet.is_held
    for _ in range(3000):
        assert not sheet.advance(GRASP).any()
    rest = tissue().nodes
    assert np.abs(sheet.nodes - rest).max() < 5e-4


def test_jaws_that_close_away_from_the_sheet_hold_nothing():
    sheet = tissue()
    assert not sheet.grasp(GRASP + np.array([0.0, 0.0, 2.0 * CONFIG.grasp_radius]))
    assert not sheet.is_held
    assert not sheet.advance(GRASP + np.array([0.0, 0.0, 0.1])).any()


def test_the_rim_is_never_grasped_and_never_moves():
    sheet = tissue()
    fixed = rim_nodes(CONFIG)
    corner = sheet.nodes[fixed][0]
    assert not sheet.grasp(corner)
    pulled(sheet, 0.02)
    assert np.array_equal(sheet.nodes[fixed], tissue().nodes[fixed])


@pytest.mark.parametrize("stiffness", [20.0, 1000.0])
def test_a_violent_pull_stays_finite_and_settles(stiffness):
    sheet = tissue(stiffness=stiffness)
    sheet.grasp(GRASP)
    rng = np.random.default_rng(7)
    for _ in range(300):
        sheet.advance(GRASP + rng.uniform(-0.01, 0.01, 3))
    for _ in range(3000):
        force = sheet.advance(GRASP)
    assert np.isfinite(sheet.nodes).all()
    assert np.linalg.norm(force) < 0.01 * stiffness * 0.01 + 1e-3


def test_the_strain_is_zero_at_rest_and_rises_with_a_pull():
    sheet = tissue()
    assert sheet.max_strain == pytest.approx(0.0, abs=1e-9)
    sheet.grasp(GRASP)
    for k in range(500):
        sheet.advance(GRASP + np.array([0.0, 2e-5 * k, 0.0]))
    assert sheet.max_strain > 0.01


def test_reset_puts_everything_back():
    sheet = tissue()
    pulled(sheet, 0.02)
    sheet.reset()
    assert not sheet.is_held
    assert np.array_equal(sheet.nodes, tissue().nodes)
    assert not sheet.advance(GRASP).any()


def test_a_sheet_turned_in_space_pulls_the_same():
    turned = tissue(
        centre=(0.0, 0.0, 0.0),
        along=(0.0, 1.0, 0.0),
        across=(0.0, 0.0, 1.0),
        reference_point=(0.0, 0.035, 0.0),
        reference_pull=(0.0, 0.00981, -0.00196),
    )
    assert turned.grasp(np.array([0.0, 0.035, 0.0]))
    upright = tissue()
    upright.grasp(GRASP)
    for k in range(800):
        step = 1e-5 * k
        a = turned.advance(np.array([0.0, 0.035 + step, 0.0]))
        b = upright.advance(GRASP + np.array([0.0, 0.0, step]))
    assert a[1] == pytest.approx(b[2], rel=1e-6)
