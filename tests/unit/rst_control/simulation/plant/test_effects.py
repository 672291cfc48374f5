# SPDX-License-Identifier: BSD-3-Clause
"""Each effect of the plant against its formula."""

from dataclasses import replace

import numpy as np
import pytest

from rst_control.config import load_simulation_config
from rst_control.kinematics import forward
from rst_control.kinematics.robot_model import load_robot
from rst_control.simulation.plant.body_wall import BodyWall
from rst_control.simulation.plant.drifting_sensor import DriftingSensor
from rst_control.simulation.plant.drives import Drives
from rst_control.simulation.plant.encoders import Encoders
from rst_control.simulation.plant.gears import Gears
from rst_control.simulation.plant.lateness import LateQueue
from rst_control.simulation.plant.loads import add_load
from rst_control.simulation.plant.tool_play import ToolPlay

PLANT = load_simulation_config().plant
STEP = 0.001  # [s]
NONE = np.zeros(7)
STIFFNESS = np.array(PLANT.drives.inertia) * np.array(PLANT.drives.bandwidth) ** 2
TROCAR = np.array([0.4, 0.0, 0.4])


def drives(**changes):
    return Drives(replace(PLANT.drives, **changes), NONE, STEP)


def frictionless(**changes):
    without = {"static_friction": (0.0,) * 7, "sliding_friction": (0.0,) * 7}
    return drives(**without, viscous_friction=(0.0,) * 7, **changes)


def ramped(motors, speed, seconds, load=NONE):
    """Motors led at a speed; what each was behind its course at each step, shape (steps, 7)."""
    behind = []
    for number in range(1, round(seconds / STEP) + 1):
        course = np.full(7, speed * STEP * number)
        motors.advance(course, np.full(7, speed), load)
        behind.append(course - motors.position)
    return np.array(behind)


# Friction.


def test_without_friction_a_motor_follows_a_steady_course():
    behind = ramped(frictionless(), 0.05, 2.0)
    assert np.abs(behind[-1]).max() < 1e-6


def test_a_step_is_followed_as_a_critically_damped_oscillator_does():
    motors = frictionless(integral=(0.0,) * 7)
    goal, w = np.full(7, 0.01), PLANT.drives.bandwidth[0]
    for _ in range(round(1.0 / w / STEP)):
        motors.advance(goal, NONE, NONE)
    time = round(1.0 / w / STEP) * STEP
    expected = 0.01 * (1.0 - (1.0 + w * time) * np.exp(-w * time))
    assert motors.position[0] == pytest.approx(expected, rel=0.03)


def test_sliding_without_integral_it_stays_behind_by_friction_over_stiffness():
    """e = (f + viscous v) / (B w^2)."""
    config, speed = PLANT.drives, 0.2  # far above the speed of Stribeck's curve
    behind = ramped(drives(integral=(0.0,) * 7), speed, 2.0)[-1]
    friction = np.array(config.sliding_friction) + speed * np.array(config.viscous_friction)
    np.testing.assert_allclose(behind, friction / STIFFNESS, rtol=0.02)


def test_a_motor_at_rest_holds_any_load_below_static_friction():
    motors = drives(integral=(0.0,) * 7, load_known=0.0)
    for _ in range(500):
        motors.advance(NONE, NONE, 0.99 * np.array(PLANT.drives.static_friction))
    assert not motors.position.any()
    for _ in range(500):
        motors.advance(NONE, NONE, 1.05 * np.array(PLANT.drives.static_friction))
    assert np.all(motors.position < 0.0)


def test_the_part_of_the_load_that_is_known_does_not_push():
    motors = frictionless(integral=(0.0,) * 7, load_known=0.9)
    for _ in range(2000):
        motors.advance(NONE, NONE, np.full(7, 10.0))
    np.testing.assert_allclose(motors.position, -0.1 * 10.0 / STIFFNESS, rtol=0.02)


def test_slow_motion_sticks_and_slips():
    motors = drives(viscous_friction=(0.0,) * 7, stribeck_speed=0.001)
    starts, speeds, stood = 0, [], True
    for number in range(1, 8000):
        motors.advance(np.full(7, 5e-4 * STEP * number), np.full(7, 5e-4), NONE)
        stands = motors.velocity[0] == 0.0
        starts, stood = starts + (stood and not stands), stands
        speeds.append(motors.velocity[0])
    assert starts >= 3  # it stands, breaks loose, and stands again
    assert max(speeds) > 4 * 5e-4  # and jumps when it breaks loose


def test_fast_motion_does_not_stick():
    motors = drives()
    behind = ramped(motors, 0.1, 2.0)
    assert np.all(motors.velocity > 0.0)
    assert np.abs(behind[-1]).max() < np.abs(behind).max()  # the integral makes it up


# Gears.


def test_a_gear_twists_by_torque_over_stiffness_and_zero_is_the_first_load():
    first, load = np.full(7, 4.0), np.full(7, 14.0)
    gears = Gears(PLANT.gears, first, STEP)
    np.testing.assert_array_equal(gears.advance(first), NONE)
    for _ in range(200):
        gears.advance(load)
    np.testing.assert_allclose(gears.twist, -10.0 / np.array(PLANT.gears.stiffness), rtol=1e-6)


def test_a_gear_settles_as_a_first_order_lag():
    gears, load = Gears(PLANT.gears, NONE, STEP), np.full(7, 10.0)
    for _ in range(round(PLANT.gears.settle_time / STEP)):
        gears.advance(load)
    expected = -10.0 / np.array(PLANT.gears.stiffness) * (1.0 - np.exp(-1.0))
    np.testing.assert_allclose(gears.twist, expected, rtol=1e-9)


def test_a_force_turns_joints_by_its_virtual_work():
    """tau . dq = F . dp for any change of the joints."""
    model = load_robot()
    q = np.array([0.1, -0.3, 0.2, 1.4, 0.1, 1.4, -1.6, 0.3, 0.2])
    frames, force = np.empty((12, 3, 4)), np.array([1.0, -2.0, 0.5])
    forward.forward(model.chain, q, frames)
    tip, torques = frames[forward.TIP, :, 3].copy(), np.zeros(9)
    add_load(frames, 9, tip, force, torques)
    for j in range(9):
        moved = q.copy()
        moved[j] += 1e-6
        forward.forward(model.chain, moved, frames)
        work = force @ (frames[forward.TIP, :, 3] - tip) / 1e-6
        assert torques[j] == pytest.approx(work, abs=1e-5)


# Sensors.


def encoders(step=1e-3, noise=0.0):
    config = replace(PLANT.encoders, step=(step,) * 10, noise=(noise,) * 10)
    return Encoders(config, np.zeros(10), STEP, np.random.default_rng(1))


def test_an_encoder_reads_whole_steps_off_by_half_a_step_at_most():
    reader, rng = encoders(), np.random.default_rng(2)
    true = rng.uniform(-1.0, 1.0, (2000, 10))
    read = np.array([reader.read(row)[0] for row in true])
    np.testing.assert_allclose(read / 1e-3, np.round(read / 1e-3), atol=1e-9)
    errors = read - true
    assert np.abs(errors).max() <= 0.5e-3 + 1e-12
    assert errors.std() == pytest.approx(1e-3 / np.sqrt(12.0), rel=0.03)


def test_an_encoders_noise_has_its_standard_deviation():
    reader = encoders(step=0.0, noise=2e-4)
    read = np.array([reader.read(np.zeros(10))[0] for _ in range(2000)])
    assert read.std() == pytest.approx(2e-4, rel=0.03)


def test_a_steady_velocity_is_read_after_its_smoothing():
    reader = encoders(step=1e-5)
    for number in range(200):
        _, velocity = reader.read(np.full(10, 0.1 * STEP * number))
    np.testing.assert_allclose(velocity, 0.1, rtol=0.02)


def test_a_sensor_has_its_noise_and_a_drift_that_wanders_within_its_own():
    config = replace(PLANT.force_sensor, noise=(0.1,) * 3, drift=(0.5,) * 3, drift_time=0.5)
    sensor = DriftingSensor(config, STEP, np.random.default_rng(3))
    read, drift = [], []
    for _ in range(60_000):
        read.append(sensor.read(np.ones(3)))
        drift.append(sensor.drift)
    np.testing.assert_allclose(np.std(drift), 0.5, rtol=0.2)
    np.testing.assert_allclose(np.std(np.array(read) - 1.0 - np.array(drift)), 0.1, rtol=0.03)
    lag = round(0.5 / STEP)
    kept = np.mean(np.array(drift[lag:]) * np.array(drift[:-lag])) / np.var(drift)
    assert kept == pytest.approx(np.exp(-1.0), abs=0.12)


def test_a_drift_begins_at_zero():
    sensor = DriftingSensor(PLANT.force_sensor, STEP, np.random.default_rng(3))
    sensor.read(np.zeros(3))
    assert np.abs(sensor.drift).max() < 1e-3


# Lateness.


def test_messages_come_late_by_delay_and_up_to_a_jitter_in_their_order():
    queue = LateQueue(0.005, 0.004, np.random.default_rng(4))
    sent, came = {}, {}
    for number in range(4000):
        now = number * 0.0005
        if number % 4 == 0:
            queue.put(number, now)
            sent[number] = now
        for item in queue.take(now):
            came[item] = now
    late = np.array([came[n] - sent[n] for n in came])
    assert list(came) == sorted(came)
    assert late.min() >= 0.005 and late.max() <= 0.009 + 0.0005
    assert late.mean() == pytest.approx(0.0075, abs=0.001)


def test_without_delay_nothing_is_late():
    queue = LateQueue(0.0, 0.0, np.random.default_rng(4))
    queue.put("a", 1.0)
    assert queue.take(1.0) == ["a"]


# The trocar.


@pytest.fixture
def still_wall():
    return BodyWall(replace(PLANT.body_wall, stroke=0.0), TROCAR)


def test_a_trocar_breathes_with_its_stroke_and_rate():
    config = PLANT.body_wall
    wall, period = BodyWall(config, TROCAR), 1.0 / config.rate
    places = np.array([wall.trocar(t) - TROCAR for t in np.linspace(0.0, period, 401)])
    away = np.linalg.norm(places, axis=1)
    assert away.max() == pytest.approx(config.stroke) and away.argmax() == 200
    assert away[0] == away[-1] == pytest.approx(0.0, abs=1e-12)
    np.testing.assert_allclose(np.cross(places, config.way), 0.0, atol=1e-12)


def test_it_pushes_a_shaft_back_by_stiffness_times_the_way_beyond_its_slack(still_wall):
    base, end = TROCAR + np.array([0.0, 0.002, 0.1]), TROCAR + np.array([0.0, 0.002, -0.2])
    force, point = still_wall.force(0.0, base, end)
    pressed = 0.002 - PLANT.body_wall.slack
    np.testing.assert_allclose(force, [0.0, -PLANT.body_wall.stiffness * pressed, 0.0], atol=1e-9)
    np.testing.assert_allclose(point, TROCAR + np.array([0.0, 0.002, 0.0]), atol=1e-12)
    aside = np.array([0.0, PLANT.body_wall.slack - 1e-6, 0.0])
    assert not still_wall.force(0.0, TROCAR + aside + [0.0, 0.0, 0.1], TROCAR + aside)[0].any()


@pytest.mark.parametrize("shift", [(0.0, 0.002, 0.3), (0.2, 0.0, 0.0)], ids=["before", "beside"])
def test_it_does_not_push_a_shaft_that_is_outside(still_wall, shift):
    base, end = TROCAR + shift + [0.0, 0.0, 0.1], TROCAR + shift - [0.0, 0.0, 0.2]
    assert not still_wall.force(0.0, base, end)[0].any()


# Play.


def play(width=0.1):
    return ToolPlay(replace(PLANT.tool_play, width=width), np.zeros(2), STEP)


def test_a_joint_follows_its_motor_only_once_the_play_is_taken_up():
    tool, still = play(), np.zeros(2)
    np.testing.assert_array_equal(tool.advance(np.full(2, 0.04), still), still)
    np.testing.assert_allclose(tool.advance(np.full(2, 0.15), still), 0.10)
    np.testing.assert_allclose(tool.advance(np.full(2, 0.06), still), 0.10)
    np.testing.assert_allclose(tool.advance(np.full(2, 0.0), still), 0.05)


def test_a_load_pushes_it_to_the_end_of_its_play_and_a_small_one_does_not():
    tool, motor = play(), np.zeros(2)
    for _ in range(200):
        tool.advance(motor, np.array([0.5, -2.0]) * PLANT.tool_play.torque)
    np.testing.assert_allclose(tool.position, [0.0, -0.05])
