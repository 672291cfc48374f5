# SPDX-License-Identifier: BSD-3-Clause
"""Latches where the parameter server holds other settings than the nodes were launched with."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Mapping
from typing import Any, Final

import rosgraph
import rospy
from diagnostic_msgs.msg import DiagnosticStatus

from rst_control.ros.controller.diagnostics import make_status
from rst_control.ros.controller.messages import code_of
from rst_control.supervision.launched_settings import LaunchedSettings, Settings
from rst_control.types import Cause, Reason
from typed_config.ros.launch_settings import KEPT, differences
from typed_config.ros.xmlrpc import FAILURES, ask

PERIOD: Final = 2.0  # [s] between looks at the server


class SettingsWatch:
    """Compares the settings of all nodes that keep those of their launch.

    A node that runs has the settings of its launch, whatever the server holds. But who changed them
    there believes that they count, and a node that is started anew by hand would take them.

    Args:
        stop: Brakes, holds and latches.
    """

    def __init__(self, stop: Callable[[Cause], None]) -> None:
        self._stop, self._settings = stop, LaunchedSettings(differences)

    def step(self) -> None:
        """Look once; a master that does not answer is no news of the settings."""
        time.sleep(PERIOD)
        try:
            nodes = _kept_settings()
        except FAILURES:
            return
        if nodes and (news := self._settings.update(nodes)):
            words = f"settings are not those of the launch: {news}"
            rospy.logerr("%s", words)
            self._stop(Cause(Reason.SETTINGS_CHANGED, words))

    def status(self) -> DiagnosticStatus:
        """What diagnostics say of it."""
        problem, level = self._settings.problem, DiagnosticStatus.OK
        if problem:
            level = DiagnosticStatus.ERROR
        words = f"not those of the launch: {problem}" if problem else "as launched"
        code = code_of(Reason.SETTINGS_CHANGED if problem else None)
        return make_status("settings", level, words, {"reason_code": code})


def _kept_settings() -> dict[str, tuple[Settings | None, Settings]]:
    """What each node of this system keeps, and what the server holds for it.

    Raises:
        OSError: The master does not answer; so do all FAILURES.
    """
    tree = _parameters(rospy.get_namespace())
    found: dict[str, tuple[Settings | None, Settings]] = {}
    for name, settings in tree.items():
        if isinstance(settings, Mapping):
            now = {key: value for key, value in settings.items() if key != KEPT}
            found[name] = _read(settings.get(KEPT)), now
    return found


def _read(kept: object) -> Settings | None:
    try:
        read = json.loads(str(kept))
    except ValueError:
        return None
    return read if isinstance(read, dict) else None


def _parameters(namespace: str) -> Mapping[str, Any]:
    found = ask(rosgraph.get_master_uri(), "getParam", rospy.get_name(), namespace)
    return found if isinstance(found, Mapping) else {}
