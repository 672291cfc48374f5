# SPDX-License-Identifier: BSD-3-Clause
"""A PyBullet world of its own."""

from __future__ import annotations

from types import TracebackType
from typing import Self

import pybullet


class BulletWorld:
    """One connection to PyBullet; a context manager.

    Args:
        mode: pybullet.DIRECT, or pybullet.GUI for a window.
    """

    def __init__(self, mode: int = pybullet.DIRECT) -> None:
        self._client = pybullet.connect(mode)

    def close(self) -> None:
        """Leave the world; calling it twice does no harm."""
        if self._client >= 0:
            pybullet.disconnect(self._client)
            self._client = -1

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()
