# SPDX-License-Identifier: BSD-3-Clause
"""report.json and report.md of a profile: what it learned, and what is to be expected of it."""

from __future__ import annotations

import json
import math
from dataclasses import asdict, dataclass

from voice_assist.enrolment.self_check import SelfCheckResult, SelfCheckTrial, confused, right
from voice_assist.profile.manifest import Manifest

JSON, MARKDOWN = "report.json", "report.md"  # in a profile


@dataclass(frozen=True)
class Effort:
    """What learning took."""

    learning: float  # [s] of CPU time, for all takes once
    whole: float  # [s] of the clock, with the check
    cpu: float  # [s] of CPU time, with the check
    memory: float  # [MB] largest resident set of the process


def as_json(
    manifest: Manifest, verdict: SelfCheckResult, problems: tuple[str, ...], effort: Effort
) -> bytes:
    """All figures of the check; no sound, and of what was said only the commands.

    A rate without a bound, as no talk was recorded, is null.
    """
    data = {
        "name": manifest.name,
        "base_sha256": manifest.base_sha256,
        "problems": problems,
        "takes": _counts(verdict.own),
        "talk": {
            "pieces": len(verdict.talk),
            "taken_by_base": sum(len(t.base) for t in verdict.talk),
            "taken_by_profile": sum(len(t.profile) for t in verdict.talk),
        },
        "others": {
            "commands": _counts([t for t in verdict.others if t.phrase]),
            "near_misses_and_talk": _accepted([t for t in verdict.others if not t.phrase]),
        },
        "expected": [
            {key: None if value == math.inf else value for key, value in asdict(one).items()}
            for one in verdict.expected
        ],
        "effort": asdict(effort),
    }
    return (json.dumps(data, indent=1, allow_nan=False) + "\n").encode()


def as_markdown(
    manifest: Manifest, verdict: SelfCheckResult, problems: tuple[str, ...], effort: Effort
) -> bytes:
    """The same for a reader."""
    own, others = _counts(verdict.own), _counts([t for t in verdict.others if t.phrase])
    lines = [f"# Profile {manifest.name}", ""]
    if problems:
        lines += ["Not active, as it failed its own check:", ""]
        lines += [f"- {problem}" for problem in problems]
    else:
        lines.append("Active.")
    lines += [
        "",
        f"Learned in {effort.learning:.0f} s; with the check {effort.whole:.0f} s of the clock, "
        f"{effort.cpu:.0f} s of CPU time and {effort.memory:.0f} MB.",
        "",
        f"Takes that were not learned from, each heard by what was learned of the others: base "
        f"{own['right_by_base']} of {own['n']} right, profile {own['right_by_profile']}.",
        f"Commands by other voices: base {others['right_by_base']} of {others['n']} "
        f"right, profile {others['right_by_profile']}.",
        "The confidences below were chosen on what is counted here, so new takes may do worse.",
        "",
        "Bounds hold with 95 % (Clopper and Pearson; Garwood), so few takes leave them wide.",
        "",
        "| command | taken from confidence | missed | at most | taken from talk | at most per h |",
        "|---|---|---|---|---|---|",
    ]
    lines += [
        f"| {e.phrase} | {e.min_confidence:.2f} | {e.missed} of {e.takes} "
        f"| {e.miss_at_most:.0%} | {e.false} | {_bound(e.false_per_hour_at_most)} |"
        for e in verdict.expected
    ]
    return ("\n".join(lines) + "\n").encode()


def _bound(rate: float) -> str:
    return "unknown" if rate == math.inf else f"{rate:.0f}"


def _counts(trials: list[SelfCheckTrial]) -> dict[str, int]:
    return {
        "n": len(trials),
        "right_by_base": right(trials, "base"),
        "right_by_profile": right(trials, "profile"),
        "another_by_base": confused(trials, "base"),
        "another_by_profile": confused(trials, "profile"),
    }


def _accepted(trials: list[SelfCheckTrial]) -> dict[str, int]:
    return {
        "n": len(trials),
        "taken_by_base": sum(bool(t.base) for t in trials),
        "taken_by_profile": sum(bool(t.profile) for t in trials),
    }
