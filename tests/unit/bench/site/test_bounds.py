# SPDX-License-Identifier: BSD-3-Clause
"""Shares and rates of trials have the bound that so few of them allow; maxima say of how many."""

import numpy as np
import pytest

from bench.kinova import suite as kinova
from bench.site import mounting, plant, stops, tension
from bench.site.plant_session import Seen
from bench.tension import suite as torques
from support.figures import percentiles

FEW = 120


def named(figures, ending):
    (found,) = [figure for figure in figures if figure.name.endswith(ending)]
    return found


def of_good_sensors(monkeypatch):
    peak = tension.TensionPeak(0, "good", "", False, 1.0, 1, 1, "", tension.RATE)
    monkeypatch.setattr(tension, "draw_situation", lambda number: number)
    monkeypatch.setattr(tension, "_is_usual", lambda number: number == 0)
    others = tension.TensionPeak(1, "good", "", False, 1.0, 1, 1, "", tension.RATE)
    return named(tension._good([peak] * FEW + [others], 2.5), "a fifth of it: not believed")


def of_losses(_):
    trials = [stops.Stopped(0.02, 1e-5, 5e-3, "")] * FEW
    return named(stops._figures("bridge lost", trials), "goes on by voice")


def of_torques(_):
    return named(torques._figures("tared", [(0.1, 0.2, "")] * FEW), "twice the estimated sigma")


def of_torques_without_a_tare(_):
    return named(torques._figures("not tared", [(0.1, 0.2, "no tare")] * FEW), "trusted")


def of_starts(monkeypatch):
    monkeypatch.setattr(mounting, "STARTS", FEW)
    monkeypatch.setattr(mounting, "_refusal", lambda *_: "")
    return mounting._right_setting("upright", mounting.down(0))


def of_wrong_settings(monkeypatch):
    monkeypatch.setattr(mounting, "STARTS", FEW)
    monkeypatch.setattr(mounting, "_refusal", lambda *_: "wrong")
    return mounting._wrong_settings()[-1]


@pytest.mark.parametrize(
    ("share", "lower", "upper"),
    [
        (of_losses, 97.535, None),  # 0.05 ** (1 / 120)
        (of_torques, 97.535, None),
        (of_torques_without_a_tare, None, 2.465),
        (of_good_sensors, None, 2.465),
        (of_starts, None, 2.465),
        (of_wrong_settings, 97.535, None),
    ],
)
def test_a_share_of_few_trials_has_its_bound(monkeypatch, share, lower, upper):
    figure = share(monkeypatch)
    assert figure.unit == "%" and figure.is_met and f"of {FEW}" in figure.note
    assert figure.lower == (None if lower is None else pytest.approx(lower, abs=1e-3))
    assert figure.upper == (None if upper is None else pytest.approx(upper, abs=1e-3))


def test_needless_stops_of_an_hour_have_the_bound_of_an_hour():
    seen = Seen(rcm=[0.0], tip=[0.0], force=[0.0], triangulated=[True] * FEW, seconds=3600.0)
    figures = plant.figures_of("ideal", [seen], is_fixed=True)
    stopped = named(figures, "needless stops per hour")
    assert (stopped.value, stopped.unit, stopped.target) == (0.0, "per h", 0.0)
    assert stopped.upper == pytest.approx(2.996, abs=1e-3) and not stopped.is_shown
    seen.seconds /= 2
    assert named(plant.figures_of("ideal", [seen], True), "per hour").target is None


def test_a_maximum_says_of_how_many():
    ended = kinova.Ended(0.02, 0.1, 1e-3, 1e-5)
    figures = kinova._ended("stop", [ended] * 6)
    for what in ("time max", "way max", "RCM error max"):
        assert "6 times" in named(figures, what).note
    assert named(percentiles("late", list(np.arange(40.0)), "ms"), "max").note == "n=40"
