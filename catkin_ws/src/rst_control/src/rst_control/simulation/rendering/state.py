# SPDX-License-Identifier: BSD-3-Clause
"""What is drawn: sent to the drawing process once, and for each picture."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from rst_control.config import CameraConfig, SceneConfig


@dataclass(frozen=True)
class SceneSetup:
    """What the process needs to know, sent once."""

    scene: SceneConfig
    cameras: tuple[CameraConfig, ...]
    urdf: Path
    window: bool  # a window, as the first camera sees it, instead of pictures; needs a screen


@dataclass(frozen=True, eq=False)
class SceneState:
    """What changes from picture to picture."""

    joints: NDArray[np.float64]  # (10,), [rad]
    nodes: NDArray[np.float64]  # (columns * rows, 3), [m], of the tissue
    held: int = -1  # number of the node that the jaws hold; -1: none
    tip: NDArray[np.float64] = field(default_factory=lambda: np.zeros(3))  # (3,), [m]
    force: NDArray[np.float64] = field(default_factory=lambda: np.zeros(3))  # (3,), [N], on jaws
    # (n, 3), [m], where the tip was, oldest first
    trail: NDArray[np.float64] = field(default_factory=lambda: np.zeros((0, 3)))
