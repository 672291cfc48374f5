# SPDX-License-Identifier: BSD-3-Clause
"""Nodes that plan no motion start without the compiled kernels: 70 MB and 0.3 s each."""

from __future__ import annotations

import subprocess
import sys

import pytest

LOADED = "import sys, {module}; print(*{{'numba', 'torch', 'pybullet'}} & {{*sys.modules}})"


@pytest.mark.parametrize(
    ("module", "heavy"),
    [
        ("voice_assist.ros.display.node", ""),
        ("voice_assist.ros.pedal.node", ""),
        ("voice_assist.ros.devices.node", ""),
        ("voice_assist.ros.alarms.node", ""),
        ("session_log.ros.recorder_node", ""),
        ("rst_control.ros.controller.node", "numba"),  # it does plan
    ],
)
def test_what_a_node_loads(module: str, heavy: str) -> None:
    line = [sys.executable, "-c", LOADED.format(module=module)]
    found = subprocess.run(line, capture_output=True, text=True, check=True)
    assert found.stdout.strip() == heavy
