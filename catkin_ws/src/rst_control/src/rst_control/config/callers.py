# SPDX-License-Identifier: BSD-3-Clause
"""The part of controller.yaml that says who may give commands, and how often."""

from __future__ import annotations

from dataclasses import dataclass

from typed_config import integer, number, text
from typed_config.node_names import require_names


@dataclass(frozen=True, kw_only=True)
class CallersConfig:
    """Who may call the services and send goals; "stop" is taken from anybody, however often."""

    allowed: tuple[str, ...] = text()
    rate: float = number(1.0, 1000.0, "1/s")
    burst: int = integer(1, 1000)

    def __post_init__(self) -> None:
        require_names("allowed", self.allowed)
