# SPDX-License-Identifier: BSD-3-Clause
"""On how much a result of the plants rests."""

import json
from contextlib import nullcontext
from dataclasses import asdict

from bench.common.part import MEASURED
from bench.site import plant
from bench.site.plant_session import Seen


def test_a_run_rests_on_the_plant_with_the_least_and_one_left_out_has_none(monkeypatch, tmp_path):
    def carried_out(part, jobs, one, processes):
        for _, path in list(jobs)[:-1]:  # time is up before the last
            seen = Seen(rcm=[0.0], tip=[0.0], force=[0.0], seconds=65.0)
            path.write_text(json.dumps(asdict(seen)), encoding="utf-8")
            yield path

    monkeypatch.setattr(plant, "SECONDS", 180.0)
    monkeypatch.setattr(plant, "pool", lambda *_: nullcontext())
    monkeypatch.setattr(plant, "carried_out", carried_out)
    for chosen, least in ((plant.ALL_PLANTS, 130.0), (plant.ALL_PLANTS[:1], 0.0)):
        folder = tmp_path / str(len(chosen))
        folder.mkdir()
        monkeypatch.setattr(plant, "PLANTS", chosen)
        monkeypatch.setattr(plant, "_file", lambda job, to=folder: to / f"{job}.json")
        for lead in ("set-points", "velocities"):
            rests, *figures = plant.measured(lead)
            assert (rests.name, rests.value, rests.target) == (MEASURED, least, 3600.0)
            assert figures
