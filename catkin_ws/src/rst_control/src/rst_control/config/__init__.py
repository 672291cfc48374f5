# SPDX-License-Identifier: BSD-3-Clause
"""Settings: one frozen dataclass per YAML file."""

from rst_control.config.motion import (
    CONFIG_FOLDER,
    EMPTY,
    PACKAGE,
    URDF_FILE,
    ControllerConfig,
    LimitsConfig,
    MotionConfig,
    RcmConfig,
    SimulationConfig,
    SolverConfig,
    TensionConfig,
    WatchdogConfig,
    load_motion_config,
    load_simulation_config,
)
from rst_control.config.scene import (
    SceneConfig,
    TissueConfig,
    TriangulationConfig,
)
from rst_control.config.simulator import (
    CameraConfig,
    ServoConfig,
    SimulatorConfig,
)

__all__ = [
    "CONFIG_FOLDER",
    "EMPTY",
    "PACKAGE",
    "URDF_FILE",
    "CameraConfig",
    "ControllerConfig",
    "LimitsConfig",
    "MotionConfig",
    "RcmConfig",
    "SceneConfig",
    "ServoConfig",
    "SimulationConfig",
    "SimulatorConfig",
    "SolverConfig",
    "TensionConfig",
    "TissueConfig",
    "TriangulationConfig",
    "WatchdogConfig",
    "load_motion_config",
    "load_simulation_config",
]
