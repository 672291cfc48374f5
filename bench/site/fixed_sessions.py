# SPDX-License-Identifier: BSD-3-Clause
"""What the robot does in fixed sessions, so that a change of code elsewhere ages no figure.

A session of commands is simulated in each plant, led by set-points and by velocities. Where two
versions of the code move alike in all that are led so, figures of the older one are marked so on
the page.
Run `python -m bench.site.fixed_sessions` before and after a change of the controller.

The last digits depend on the processor. On another one, run it in a checkout of an older version
first, then here with the file that it left there: `python -m bench.site.fixed_sessions FILE`.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any, Final

from bench.common.resumable import digest
from bench.site.plant import ALL_PLANTS, REFUSED, make_rig
from bench.site.plant_session import Session
from support.figures import FIXED_SESSIONS, noted
from support.product_code import CONTROLLER, KINOVA, PLANT, SIMULATION, identity

LEADS: Final = ("set-points", "velocities")
SECONDS: Final = 12.0  # simulated, of each
DIGITS: Final = 9  # of what is measured in SI units: nanometres


def moved(lead: str) -> str:
    """Digest of all that the sessions showed in which the arm is led so."""
    seen = {}
    for plant in ALL_PLANTS:
        if (lead, plant) != REFUSED:
            with make_rig(lead, plant) as rig:
                session = Session(rig, lead == "velocities").run(SECONDS)
            seen[plant] = digest(_rounded(asdict(session)))
    return digest(seen)


def note(found: Mapping[str, str], older: Mapping[str, str]) -> None:
    """Note what the present code does, beside what older code did; by what leads the arm.

    Args:
        found: Digests of the present code.
        older: What is noted where an older version ran on this processor.
    """
    codes = [identity(rooms) for rooms in (CONTROLLER, SIMULATION, KINOVA, PLANT)]
    present = {f"{lead} {code}": what for lead, what in found.items() for code in codes}
    known = translated(noted(FIXED_SESSIONS), older)
    text = json.dumps(known | present, indent=1) + "\n"
    FIXED_SESSIONS.write_text(text, encoding="utf-8")


def translated(known: Mapping[str, str], here: Mapping[str, str]) -> dict[str, str]:
    """Digests of another processor in those of this one, by the versions that ran on both.

    Versions that moved alike there move alike here.

    Raises:
        ValueError: Versions that moved alike there do not here.
    """
    names: dict[tuple[str, str], str] = {}
    for key in known.keys() & here.keys():
        if here[key] != known[key]:
            lead = key.split()[0]
            if names.setdefault((lead, known[key]), here[key]) != here[key]:
                raise ValueError(f"{lead}: {known[key]} has two digests on this processor")
    return {key: names.get((key.split()[0], what), what) for key, what in known.items()}


def _rounded(value: Any) -> Any:
    if isinstance(value, float):
        return round(value, DIGITS) + 0.0  # no minus zero
    if isinstance(value, dict):
        return {key: _rounded(one) for key, one in value.items()}
    return [_rounded(one) for one in value] if isinstance(value, list | tuple) else value


if __name__ == "__main__":
    older = json.loads(Path(sys.argv[1]).read_text(encoding="utf-8")) if len(sys.argv) > 1 else {}
    note({lead: moved(lead) for lead in LEADS}, older)
