# SPDX-License-Identifier: BSD-3-Clause
"""crtk.yaml: how often the arm is shown to clients of CRTK, and when it counts as gone."""

from __future__ import annotations

from dataclasses import dataclass

from rst_control.config.believed import NodeNames
from rst_control.config.motion import CONFIG_FOLDER
from typed_config import number, text

CRTK_FILE = CONFIG_FOLDER / "crtk.yaml"


@dataclass(frozen=True, kw_only=True)
class CrtkBelievedConfig(NodeNames):
    """Nodes whose messages count for CRTK's node; [] stands for anybody."""

    controller: tuple[str, ...] = text()
    robot: tuple[str, ...] = text()
    clients: tuple[str, ...] = text()


@dataclass(frozen=True, kw_only=True)
class CrtkConfig:
    """crtk.yaml."""

    rate: float = number(1.0, 500.0, "Hz")
    old_after: float = number(0.1, 10.0, "s")
    believed: CrtkBelievedConfig
