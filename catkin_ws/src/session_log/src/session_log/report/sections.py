# SPDX-License-Identifier: BSD-3-Clause
"""What the page of one session and that over many have in common."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from session_log.report.figures import ReportFigure
from session_log.report.page import Image, Section
from session_log.report.pool.pool import Pool
from session_log.report.session.analysis import FAILED
from session_log.report.tables import pool_tables
from session_log.report.tables.text_table import length, newtons, percent, seconds

OF_THEM_REFUSED = "of them refused by the controller"
FAILURES = "Device calls that failed, and why"
INPUTS_NOTE = (
    "Action: time from the end of speech, or from the controller's answer to a pedal or a hand. In "
    "brackets: exact 95 % confidence bounds. Taken for another: known where it was recorded what "
    "was to be said."
)


def large_facts(pool: Pool, commands: Mapping[str, int]) -> dict[str, str]:
    """The figures that are set large.

    Args:
        pool: The sessions.
        commands: How many there were, and of them refused, by what is said beside the number.
    """
    _, total, share = pool.accuracy()
    action = pool.latencies().action
    facts = {name: str(count) for name, count in commands.items()}
    if failed := pool.outcomes[FAILED]:
        facts["device calls that failed"] = str(failed)
    facts["speech that did nothing"] = str(pool.ignored)
    if total:
        facts[f"of {total} commands taken as meant"] = percent(share.value)
    if action:
        facts["end of speech to action, mean"] = seconds(sum(action) / len(action))
    if pool.rcm.count:
        facts["largest RCM error while moving"] = length(pool.rcm.largest)
    if math.isfinite(pool.tension):
        facts["largest tension"] = newtons(pool.tension)
    return facts


def figure_section(figure: ReportFigure[Any], images: Mapping[str, Image], pool: Pool) -> Section:
    """A figure with the pool's table that belongs to it, or what is said in its place."""
    image = images.get(figure.name)
    section = Section(figure.title, "" if image else figure.lacking, image)
    if figure.name == "accuracy" and image:
        return replace(section, table=pool_tables.accuracy_table(pool))
    if figure.name == "latency" and pool.latencies().decision:
        table, source = pool_tables.latency_table(pool), _latency_source(pool)
        return replace(section, table=table, source=source)
    return section


def inputs_section(pool: Pool) -> Section:
    """Voice beside pedals and hands."""
    return Section("Voice, pedal and hand", INPUTS_NOTE, table=pool_tables.inputs_table(pool))


def _latency_source(pool: Pool) -> str:
    """What the brackets and the paper's column of the latency table are."""
    paper = pool.config.paper
    return (
        "In brackets: exact 95 % confidence bounds, where there are values enough: 6 for a "
        f"median, 72 for a 95th percentile. Paper: {paper.source}; {paper.repetitions} of each "
        f"command on an {paper.hardware}; its time runs from the end of the request to the "
        "robot's action."
    )
