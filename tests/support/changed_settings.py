# SPDX-License-Identifier: BSD-3-Clause
"""Settings of motion with some keys changed, and a planner that has them."""

from dataclasses import replace

from rst_control.planning.planner import Planner


def changed(config, **parts):
    """The settings with some keys of sections, or of parts of the controller: scene={"home": q}."""
    own, controller = {}, {}
    for name, keys in parts.items():
        of, into = (config, own) if hasattr(config, name) else (config.controller, controller)
        into[name] = replace(getattr(of, name), **keys)
    if controller:
        own["controller"] = replace(config.controller, **controller)
    return replace(config, **own)


def planner_with(planner, **parts):
    """A planner for the same robot whose settings are changed so."""
    return Planner(planner.model, changed(planner.config, **parts))
