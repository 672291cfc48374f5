# SPDX-License-Identifier: BSD-3-Clause
"""Which calls follow what was said, and which undo them at a stop."""

from __future__ import annotations

from dataclasses import dataclass

from voice_assist.config.devices import DeviceCallConfig, DevicesConfig


@dataclass(frozen=True)
class CallResult:
    """What came of a call, in words for people."""

    call: DeviceCallConfig
    is_done: bool
    words: str


class DeviceCalls:
    """Follows commands, results and stops.

    Args:
        config: The allow-list.
    """

    def __init__(self, config: DevicesConfig) -> None:
        self._config = config
        self._undone_by: dict[str, str] = {}  # phrase of what was asked for: of what undoes it

    def said(self, phrase: str) -> DeviceCallConfig | None:
        """The call that a spoken command makes; None: it is not for a device."""
        call = self._config.get(phrase)
        if call is None:
            return None
        # From the request on: whether a call that failed had an effect is not known.
        if call.on_stop:
            self._undone_by[call.phrase] = call.on_stop
        self._undone_by = {p: u for p, u in self._undone_by.items() if u != call.phrase}
        return call

    def stopped(self) -> tuple[DeviceCallConfig, ...]:
        """The calls that undo what was asked for since the last stop, each once."""
        undoing = dict.fromkeys(reversed(self._undone_by.values()))
        self._undone_by.clear()
        return tuple(call for phrase in undoing if (call := self._config.get(phrase)))
