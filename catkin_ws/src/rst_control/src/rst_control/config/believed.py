# SPDX-License-Identifier: BSD-3-Clause
"""Which nodes are believed, by the names that they give themselves."""

from __future__ import annotations

from dataclasses import dataclass, fields

from typed_config import text
from typed_config.node_names import require_names


@dataclass(frozen=True, kw_only=True)
class NodeNames:
    """Settings of which each lists nodes."""

    def __post_init__(self) -> None:
        """Check what no key shows alone."""
        for field in fields(self):
            require_names(field.name, getattr(self, field.name))


@dataclass(frozen=True, kw_only=True)
class BelievedConfig(NodeNames):
    """Nodes whose messages count for the controller; [] stands for anybody."""

    robot: tuple[str, ...] = text()
    tension: tuple[str, ...] = text()
    recorder: tuple[str, ...] = text()
    pedal: tuple[str, ...] = text()


@dataclass(frozen=True, kw_only=True)
class BridgeBelievedConfig(NodeNames):
    """Nodes whose messages count for the bridge; [] stands for anybody."""

    controller: tuple[str, ...] = text()
    guard: tuple[str, ...] = text()
    arm: tuple[str, ...] = text()
    tool: tuple[str, ...] = text()
    sensors: tuple[str, ...] = text()
