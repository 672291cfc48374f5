# SPDX-License-Identifier: BSD-3-Clause
"""Tension from joint torques: its value, how far it is trusted, and why not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from rst_control.config import URDF_FILE, load_motion_config
from rst_control.config.torque_tension import TorqueTensionConfig, load_torque_tension
from rst_control.kinematics.configuration import Configuration, robot_joints
from rst_control.kinematics.inverse_dynamics import InverseDynamics
from rst_control.tension.torque_estimator import (
    TensionEstimate,
    TorqueTension,
    load_matrix,
)
from rst_control.types import Measurement, unit_vector
from tests.support.jacobians import rcm_jacobian_at
from typed_config import ConfigError

Array = NDArray[np.float64]
TEXT = URDF_FILE.read_text(encoding="utf-8")
SCENE = load_motion_config().scene
HOME, TROCAR = np.array(SCENE.home), np.array(SCENE.trocar)
CONFIG = load_torque_tension()
PULL = unit_vector(SCENE.pull_direction)
PERIOD = 0.025  # [s] of the arm's feedback
OPEN, CLOSED = 0.6, 0.0


class Arm:
    """An arm whose torques are exact but for a bias, with a pull and a trocar's load on it."""

    def __init__(self, config: TorqueTensionConfig = CONFIG) -> None:
        self.estimator, self.dynamics = TorqueTension(config, TEXT, SCENE), InverseDynamics(TEXT)
        self.now, self.bias, self.speed = 0.0, np.zeros(7), np.zeros(10)
        self.sign, self.pushed = 1.0, np.zeros(7)
        self.q = HOME

    def read(self, load: tuple[float, float, float], opening: float, gripped: bool) -> Measurement:
        """One reading under a pull and two forces across the shaft [N]."""
        A = load_matrix(self.estimator._dynamics.model, self.q, TROCAR, PULL)
        motors = self.dynamics(self.q) + A @ np.array(load) + self.bias + self.pushed
        return Measurement(
            position=robot_joints(self.q, opening),
            velocity=self.speed,
            effort=np.append(self.sign * motors, [0.0, 0.0, 0.0]),
            stamp=self.now,
            gripped=gripped,
        )

    def rest(self, seconds: float = 1.0) -> TensionEstimate:
        """Jaws open, nothing held."""
        return self.feel((0.0, 0.0, 0.0), seconds, OPEN, gripped=False)

    def feel(
        self,
        load: tuple[float, float, float],
        seconds: float = 1.0,
        opening: float = CLOSED,
        gripped: bool = True,
    ) -> TensionEstimate:
        for _ in range(round(seconds / PERIOD)):
            self.now += PERIOD
            found = self.estimator.update(self.read(load, opening, gripped), TROCAR)
        return found


@pytest.fixture
def arm() -> Arm:
    arm = Arm()
    arm.rest()
    return arm


def test_a_pull_is_found_to_its_size(arm: Arm) -> None:
    found = arm.feel((1.2, 0.0, 0.0))
    assert found.tension == pytest.approx(1.2, abs=1e-3)
    np.testing.assert_allclose(found.force, -1.2 * PULL, atol=1e-3)
    assert found.tension_invalid_reason == ""


def test_a_shaft_that_leans_on_its_trocar_is_no_tension(arm: Arm) -> None:
    found = arm.feel((0.5, 3.0, -2.0))
    assert found.tension == pytest.approx(0.5, abs=1e-3)
    np.testing.assert_allclose(found.lateral, [3.0, -2.0], atol=1e-2)


def test_the_tare_takes_away_what_is_wrong_all_the_time(arm: Arm) -> None:
    arm.bias = np.array([0.5, -0.7, 0.3, 0.6, -0.1, 0.15, 0.05])
    arm.rest(2.0)
    assert arm.feel((1.0, 0.0, 0.0)).tension == pytest.approx(1.0, abs=1e-3)


@pytest.mark.parametrize("rest", [0.2, 0.3, 0.45, 0.6, 0.8])
def test_what_the_filter_still_holds_of_a_motion_is_no_bias(arm: Arm, rest: float) -> None:
    arm.speed, arm.pushed = np.full(10, 0.05), np.array([0.5, -0.7, 0.3, 0.6, -0.1, 0.15, 0.05])
    arm.rest()  # braking, with the jaws open
    arm.speed, arm.pushed = np.zeros(10), np.zeros(7)
    arm.rest(rest)
    assert arm.feel((1.0, 0.0, 0.0)).tension == pytest.approx(1.0, abs=0.03)


def test_tissue_that_was_just_let_go_is_no_bias(arm: Arm) -> None:
    arm.feel((2.0, 0.0, 0.0), 1.0, OPEN, gripped=True)
    arm.rest(0.3)
    assert arm.feel((1.0, 0.0, 0.0)).tension == pytest.approx(1.0, abs=0.03)


def test_without_a_tare_it_says_so_and_what_it_is_worth() -> None:
    arm = Arm()
    arm.bias = np.array(CONFIG.error.offset)
    found = arm.feel((1.0, 0.0, 0.0))
    assert found.tension_invalid_reason.startswith("no tare")
    assert found.sigma > 2.0 * abs(found.tension - 1.0) / 3.0  # as unsure as it is wrong


@pytest.mark.parametrize(("turned", "later"), [(0.4, 0.0), (0.0, CONFIG.tare.holds_for)])
def test_where_a_tare_holds_no_more_its_bias_is_no_sudden_tension(
    turned: float, later: float
) -> None:
    arm = Arm()
    arm.bias = np.array([0.5, -0.7, 0.3, 0.6, -0.1, 0.15, 0.05])
    arm.rest(2.0)
    assert arm.feel((0.3, 0.0, 0.0)).tension_invalid_reason == ""
    arm.q = HOME + turned * np.eye(9)[3]
    arm.now += later
    found = arm.feel((0.3, 0.0, 0.0))
    assert "tare" in found.tension_invalid_reason
    assert found.tension == pytest.approx(0.3, abs=1e-3)


def test_jaws_that_hold_something_give_no_tare() -> None:
    arm = Arm()
    held = arm.feel((1.0, 0.0, 0.0), 2.0, OPEN, gripped=True)
    assert held.tension_invalid_reason.startswith("no tare: ")
    closed = arm.feel((0.0, 0.0, 0.0), 2.0, CLOSED, gripped=False)  # they may hold what slipped in
    assert closed.tension_invalid_reason.startswith("no tare: ")


@pytest.mark.parametrize(
    ("name", "more", "words"),
    [
        ("q", 0.4 * np.eye(9)[1], "joint_2 is 0.40 rad from where it was taken, allowed 0.35"),
        ("now", CONFIG.tare.holds_for + 1.0, "s old, allowed 600"),
        ("speed", 0.5 * np.eye(10)[3], "joint_4 at 0.50 rad/s"),
        ("pushed", 6.0 * np.eye(7)[2], "misfit"),
    ],
    ids=["elsewhere", "long after", "in fast motion", "with a pushed elbow"],
)
def test_away_from_the_tare_in_motion_or_pushed_it_is_not_trusted(
    arm: Arm, name: str, more: Array | float, words: str
) -> None:
    setattr(arm, name, getattr(arm, name) + more)
    assert words in arm.feel((1.0, 0.0, 0.0)).tension_invalid_reason


def moved(q: Array, way: Array) -> Array:
    """Configuration with the tip moved by a way [m]."""
    J = Configuration(InverseDynamics(TEXT).model, q).J_tip[:3]
    return q + np.linalg.pinv(J) @ way


def off(angle: float) -> Array:
    """Unit vector so far [deg] off the way of the pull."""
    across = unit_vector(np.cross(PULL, [0.0, 1.0, 0.0]))
    return np.cos(np.radians(angle)) * PULL + np.sin(np.radians(angle)) * across


@pytest.mark.parametrize(
    ("way", "refused"),
    [
        (6e-3 * off(15.0), ""),
        (6e-3 * off(25.0), "moved 25 deg off scene.pull_direction since the grasp, allowed 20"),
        (6e-3 * off(60.0), "moved 60 deg off"),
        (6e-3 * off(120.0), "moved 120 deg off"),
        (2e-3 * off(90.0), ""),  # too short to say which way
    ],
)
def test_tissue_that_is_pulled_another_way_is_not_trusted_until_its_release(
    arm: Arm, way: Array, refused: str
) -> None:
    arm.feel((0.1, 0.0, 0.0))
    arm.q = moved(HOME, way)
    words = arm.feel((0.5, 0.0, 0.0)).tension_invalid_reason
    assert refused in words
    assert bool(refused) == bool(words)
    arm.rest()
    assert arm.feel((0.5, 0.0, 0.0)).tension_invalid_reason == ""


def test_a_scene_that_leaves_the_way_of_the_pull_open_is_refused() -> None:
    with pytest.raises(ConfigError, match=r"scene\.pull_direction.*three numbers"):
        TorqueTension(CONFIG, TEXT, replace(SCENE, pull_direction=()))


def test_noisy_torques_are_not_trusted() -> None:
    noisy = replace(CONFIG.error, noise=tuple(10.0 * n for n in CONFIG.error.noise))  # type: ignore[arg-type]
    arm = Arm(replace(CONFIG, error=noisy))
    arm.rest()
    assert "allowed 0.25 N" in arm.feel((1.0, 0.0, 0.0)).tension_invalid_reason


def test_after_a_gap_it_begins_anew(arm: Arm) -> None:
    arm.feel((1.0, 0.0, 0.0))
    arm.now += 2.0 * CONFIG.gap
    assert "torque readings so far" in arm.feel((0.0, 0.0, 0.0), PERIOD).tension_invalid_reason
    assert arm.feel((0.0, 0.0, 0.0)).tension == pytest.approx(0.0, abs=1e-3)


def test_efforts_of_the_other_sign_are_found_and_can_be_turned() -> None:
    arm = Arm()
    arm.sign = -1.0
    assert "change effort_sign" in arm.rest().tension_invalid_reason
    turned = Arm(replace(CONFIG, effort_sign=-1))
    turned.sign = -1.0
    turned.rest()
    assert turned.feel((1.0, 0.0, 0.0)).tension_invalid_reason == ""


def test_a_rising_pull_is_reported_late_by_the_filters_time(arm: Arm) -> None:
    rate = 1.0  # [N/s]
    for _ in range(80):
        arm.now += PERIOD
        true = rate * (arm.now - 1.0)
        found = arm.estimator.update(arm.read((true, 0.0, 0.0), CLOSED, True), TROCAR)
    assert (true - found.tension) / rate == pytest.approx(CONFIG.filter_time, abs=PERIOD)


def test_a_reading_seen_twice_counts_once(arm: Arm) -> None:
    reading = arm.read((1.0, 0.0, 0.0), CLOSED, True)
    once = arm.estimator.update(reading, TROCAR).tension
    assert arm.estimator.update(reading, TROCAR).tension == once


def test_the_reported_spread_is_the_true_one() -> None:
    """Of noise alone."""
    quiet = replace(
        CONFIG.error,
        offset=(0.0,) * 7,
        friction=(0.0,) * 7,
        gain=0.0,
        model=0.0,
        tool_mass=0.0,
        trocar_friction=0.0,
    )
    config = replace(CONFIG, error=quiet, filter_time=0.0)
    arm, rng, reported = Arm(config), np.random.default_rng(5), []
    arm.rest()
    noise, errors = np.array(CONFIG.error.noise), []
    for _ in range(800):
        arm.pushed = rng.normal(size=7) * noise
        found = arm.feel((1.0, 0.0, 0.0), PERIOD)
        errors.append(found.tension - 1.0)
        # The tare is exact here. It counts as noisy as the readings: for half of the variance.
        reported.append(0.5 * found.sigma**2)
    assert np.std(errors) == pytest.approx(np.sqrt(np.mean(reported)), rel=0.1)


def test_columns_of_the_loads_are_power_over_speed() -> None:
    """Virtual work: a motor's torque times its speed is the force times the speed of its point."""
    model = Arm().estimator._dynamics.model
    A = load_matrix(model, HOME, TROCAR, PULL)
    rng = np.random.default_rng(1)
    for _ in range(10):
        dq = np.append(rng.normal(size=7), [0.0, 0.0])
        step = 1e-6 * dq
        moved = (Configuration(model, HOME + step).tip - Configuration(model, HOME - step).tip) / 2
        assert A[:, 0] @ step[:7] == pytest.approx(float(PULL @ moved), rel=1e-6, abs=1e-12)
        J = rcm_jacobian_at(Configuration(model, HOME), TROCAR)  # moves the trocar past the shaft
        np.testing.assert_allclose(A[:, 1:].T @ dq[:7], J @ dq, atol=1e-9)
