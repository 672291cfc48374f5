# SPDX-License-Identifier: BSD-3-Clause
"""Measurements of a robot that moves as commanded, to be spoilt by the tests of the sensors."""

from dataclasses import replace

import numpy as np

from rst_control.config import load_motion_config
from rst_control.supervision.plausibility import SensorWatch, max_joint_speed
from rst_control.types import Measurement

CONFIG = load_motion_config()
SETTINGS = CONFIG.controller
PERIOD = 1.0 / SETTINGS.rate
SENSORS = SETTINGS.watchdogs.sensors
LATE = 4  # periods by which the robot follows its set-point
TOOL_STEP = 2.0 * np.pi / 3640  # [rad] of OpenRST's coarsest encoder, were it geared by nothing
STEPS = np.repeat([1e-5, TOOL_STEP], [7, 3])


def watch(**watchdogs):
    """With other settings of the watchdogs."""
    settings = replace(SETTINGS, watchdogs=replace(SETTINGS.watchdogs, **watchdogs))
    return SensorWatch(settings, max_joint_speed(CONFIG.limits))


def swing(rate, start=0.0):
    """A motion that swings at up to `rate` [rad/s], from rest, after `start` [s]."""

    def at(time):
        t = max(0.0, time - start)
        return 0.2 + rate / 3.0 * (1.0 - np.cos(3.0 * t)), rate * np.sin(3.0 * t)

    return at


def ramp(rate, start=0.0):
    """A motion at a steady speed [rad/s] after `start` [s]."""
    return lambda time: (
        0.2 + rate * max(0.0, time - start),
        rate if time > start else 0.0,
    )


def measurements(motion, seconds):
    """Exact measurements, with the set-point active at each. All joints move alike."""
    for k in range(round(seconds / PERIOD)):
        time = k * PERIOD
        position, velocity = motion(time - LATE * PERIOD)
        setpoint = np.full(10, motion(time)[0])
        yield (
            Measurement(
                position=np.full(10, position),
                velocity=np.full(10, velocity),
                effort=np.zeros(10),
                stamp=100.0 + time,
                sent=5e8 + time,
            ),
            setpoint,
        )


def first_objection(motion, seconds=2.0, spoil=lambda k, m: m, **watchdogs):
    """First objection and the time at which it came [s]; ("", inf) where none came."""
    sensors = watch(**watchdogs)
    for k, (measured, setpoint) in enumerate(measurements(motion, seconds)):
        sensors.update(spoil(k, measured), setpoint, None)
        if sensors.objection:
            return sensors.objection, k * PERIOD
    return "", np.inf


def coarse(rng, steps=STEPS, speed_noise=5e-3):
    """Spoils measurements as encoders and filters do: steps, noise."""

    def spoil(k, m):
        noisy = m.position + rng.normal(0.0, 0.2 * steps)
        position = np.round(noisy / steps) * steps
        return replace(m, position=position, velocity=m.velocity + rng.normal(0, speed_noise, 10))

    return spoil


def pull(force_at, seconds=1.0, speed=0.01, **changes):
    """First objection while tissue is pulled; force [N] by the place [m]."""
    sensors = watch()
    for k, (measured, setpoint) in enumerate(measurements(ramp(0.0), seconds)):
        s = speed * k * PERIOD
        spoilt = replace(measured, force=np.array([0.0, 0.0, -force_at(s)]), gripped=True)
        sensors.update(replace(spoilt, **changes), setpoint, s)
        if sensors.objection:
            return sensors.objection, s
    return "", np.inf
