# SPDX-License-Identifier: BSD-3-Clause
"""Several drivers of one joystick topic: who holds an input, and whose news of it count."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Final

from voice_assist.config.pedal import BindingConfig, PedalConfig
from voice_assist.pedal.pedals import STOP, Pedals

MUTE: Final = "mute"  # its release permits, that of all others forbids


class Drivers:
    """What one driver holds is released by that driver, or by its loss, and by nobody at rest.

    Args:
        config: What each input does.
        pedals: How the inputs are now.
        is_alive: Whether a driver can still be heard.
    """

    def __init__(
        self, config: PedalConfig, pedals: Pedals, is_alive: Callable[[str], bool]
    ) -> None:
        self._bindings: Mapping[str, BindingConfig] = {b.input: b for b in config.bindings}
        self._pedals, self._is_alive = pedals, is_alive
        self._holding: dict[str, set[str]] = {}  # by input, drivers whose last news pressed it

    def counting(self, driver: str, values: Mapping[str, float]) -> dict[str, float]:
        """The news of a driver without what another one, which is alive, forbids."""
        return {name: value for name, value in values.items() if self._counts(driver, name, value)}

    def _counts(self, driver: str, name: str, value: float) -> bool:
        binding = self._bindings.get(name)
        if binding is None or binding.command == STOP:
            return True  # sent too often it does no harm; left out, one of two could be lost
        holding = self._holding.setdefault(name, set())
        was_holding, is_mute = driver in holding, binding.does == MUTE
        if self._pedals.presses(name, value):
            holding.add(driver)
            is_old = was_holding and self._pedals.state(name) is False  # another released it
            return is_mute or not is_old
        holding.discard(driver)
        is_own = was_holding and not is_mute
        return is_own or not any(map(self._is_alive, holding))
