# SPDX-License-Identifier: BSD-3-Clause
"""Tension of the tissue: as it was measured, with its target, and what the settings say of it."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from typing import Any

import numpy as np
import yaml

from session_log.recording.metadata import PARAMETERS
from session_log.report.session.session_data import SILENT, SampledTable, SessionData, Track

Settings = Mapping[str, Any]


def measured_tension(data: SessionData, topic: str) -> SampledTable:
    """Columns time [s] and tension [N], which may be nan; without rows where nothing measured it.

    The controller without a sensor reports 0 N. So its own samples count only where the settings
    name a source, or, without settings, where the topic was recorded.

    Args:
        data: Of the session.
        topic: Of the measured tension.
    """
    if len(data.tension):
        return data.tension
    source = tension_settings(data).get("source")
    is_measured = source != "none" and (source or topic in data.recording.topics)
    return data.controller if is_measured else data.tension


def tension_with_target(data: SessionData) -> Track:
    """Tension while there is a target [N], as it was measured. Shape (n,).

    Before the first word of the controller, and while it is silent, nobody knows the target.
    """
    table = data.controller
    measured = data.tension if len(data.tension) and len(table) else table
    said, time = table["time"], measured["time"]
    state = np.searchsorted(said, time, side="right") - 1
    latest = state.clip(0)
    is_known = (state >= 0) & (time - said[latest] <= SILENT)
    return measured["tension"][is_known & (table["target"][latest] > 0)]


def tension_error(data: SessionData) -> Track:
    """Distance of the tension from its target at rest with tissue under tension [N]. Shape (n,)."""
    table = data.controller
    at_rest = (table["target"] > 0) & (table["moving"] == 0)
    return np.abs(table["tension"] - table["target"])[at_rest]


def tension_settings(data: SessionData) -> Settings:
    """The recorded controller's settings of the tension; empty where none were recorded.

    Other nodes have settings of that name, too. Only those of the controller name a limit.
    """
    for text in data.recording.condition.latest(PARAMETERS).values():
        if found := _settings_of(text):
            return found
    return {}


@lru_cache(maxsize=8)  # figure, time axis and summary ask for the same text, which is long
def _settings_of(text: str) -> Settings:
    try:
        return _settings_in(yaml.safe_load(text)) if "tension:" in text else {}
    except yaml.YAMLError:
        return {}


def _settings_in(values: Any) -> Settings:
    if not isinstance(values, dict):
        return {}
    tension = values.get("tension")
    if isinstance(tension, dict) and isinstance(tension.get("limit"), (int, float)):
        return tension
    return next(filter(None, map(_settings_in, values.values())), {})
