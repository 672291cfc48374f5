# SPDX-License-Identifier: BSD-3-Clause
"""Which alarm sounds when: never two at once, the higher priority first, repeated until seen to."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from voice_assist.alarms.board import Standing
from voice_assist.alarms.earcons import PATTERNS
from voice_assist.alarms.types import Alarm, Kind, Priority
from voice_assist.config.alarms import SoundConfig

_ONLY_SEEN = (Kind.REFUSAL, Kind.NOTICE)  # while an alarm of high priority sounds
GAP = 0.25  # [s] of silence between two sounds
TOO_LATE = 1.5  # [s] after which a notice or a refusal that had to wait is no longer news


@dataclass(frozen=True)
class _Sounded:
    """When an alarm was last heard."""

    alarm: Alarm
    since: float  # [s] of the standing alarm
    times: int
    end: float  # [s] of its sound


class Annunciator:
    """Chooses the next sound.

    Args:
        config: Pauses between repetitions.
        answer_length: Of a spoken answer [s].
    """

    def __init__(
        self, config: SoundConfig, answer_length: Callable[[str], float] = lambda _: 0.0
    ) -> None:
        self._config, self._answer_length = config, answer_length
        self._sounded: dict[str, _Sounded] = {}
        self._busy_until, self._playing = float("-inf"), Priority.INFORMATION
        self._last_refusal = float("-inf")

    def next(self, standing: Sequence[Standing], now: float) -> Alarm | None:
        """The alarm to be heard now; None: none. What it gives interrupts whatever still sounds.

        Args:
            standing: What comes first in front.
            now: Time [s].
        """
        keys = {entry.key for entry in standing}
        self._sounded = {k: v for k, v in self._sounded.items() if k in keys}
        is_urgent = any(
            s.alarm.priority is Priority.HIGH and not s.is_acknowledged for s in standing
        )
        for entry in standing:
            if is_urgent and entry.alarm.kind in _ONLY_SEEN:
                continue
            if self._is_due(entry, now) and self._may_sound(entry, now):
                return self._sound(entry, now)
        return None

    def _is_due(self, entry: Standing, now: float) -> bool:
        if entry.is_acknowledged and entry.until is None:
            return False
        before = self._sounded.get(entry.key)
        is_late = entry.until is not None and now - entry.since > TOO_LATE
        if before is None or before.alarm != entry.alarm or before.since != entry.since:
            return not is_late
        if entry.until is not None:
            return entry.times > before.times and not is_late
        if entry.times > before.times and now >= before.end + GAP:
            return True
        pause = self._pause(entry.alarm.priority)
        return pause is not None and now >= before.end + pause

    def _may_sound(self, entry: Standing, now: float) -> bool:
        """Whether nothing of at least this priority still sounds, and it is not too often."""
        alarm = entry.alarm
        if alarm.kind is Kind.NOTICE and not self._config.notices:
            return False
        if now < self._busy_until and alarm.priority <= self._playing:
            return False
        too_soon = now - self._last_refusal < self._config.refusal_apart
        return not (alarm.kind is Kind.REFUSAL and too_soon)

    def _pause(self, priority: Priority) -> float | None:
        """Silence until an alarm is repeated [s]; None: it is not."""
        pauses = {
            Priority.HIGH: self._config.repeat_high,
            Priority.MEDIUM: self._config.repeat_medium,
        }
        return pauses.get(priority)

    def _sound(self, entry: Standing, now: float) -> Alarm:
        before = self._sounded.get(entry.key)
        is_news = before is None or before.alarm != entry.alarm or before.times != entry.times
        alarm = entry.alarm if is_news else replace(entry.alarm, answer="")  # said once
        end = now + PATTERNS[alarm.earcon].duration + self._answer_length(alarm.answer)
        self._sounded[entry.key] = _Sounded(entry.alarm, entry.since, entry.times, end)
        self._busy_until, self._playing = end + GAP, entry.alarm.priority
        if entry.alarm.kind is Kind.REFUSAL:
            self._last_refusal = now
        return alarm
