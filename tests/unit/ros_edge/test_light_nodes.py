# SPDX-License-Identifier: BSD-3-Clause
"""Nodes that plan no motion start without the compiled kernels: 70 MB and 0.3 s each."""

import subprocess
import sys

LIGHT = (
    "voice_assist.ros.display.node",
    "voice_assist.ros.pedal.node",
    "voice_assist.ros.devices.node",
    "voice_assist.ros.alarms.node",
    "session_log.ros.recorder_node",
)
PLANS = "rst_control.ros.controller.node"
LOADED = """
import importlib, sys
for module in sys.argv[1:]:
    importlib.import_module(module)
    print(module, *{"numba", "torch", "pybullet"} & {*sys.modules})
"""


def test_only_the_node_that_plans_loads_the_kernels():
    line = [sys.executable, "-c", LOADED, *LIGHT, PLANS]
    found = subprocess.run(line, capture_output=True, text=True, check=True).stdout
    assert found.splitlines() == [*LIGHT, f"{PLANS} numba"]
