# SPDX-License-Identifier: BSD-3-Clause
"""What stands at this moment: alarms appear, grow in priority, are acknowledged and go.

Nothing here reads a clock or waits. The owner hands in what came, with its time, and reads
`standing` afterwards.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, replace

from voice_assist.alarms.causes import SILENT
from voice_assist.alarms.presenter import (
    HEY_ROBOT,
    event_alarm,
    latch_alarm,
    part_alarm,
    unheard_alarm,
)
from voice_assist.alarms.types import (
    Alarm,
    ControllerEvent,
    Kind,
    PartHealth,
    RobotState,
    UtteranceReport,
)
from voice_assist.config.alarms import BoardConfig
from voice_assist.config.commands import CommandsConfig

_LATCH, _GIVE_UP, _REFUSAL, _NOTICE = "latch", "give-up", "refusal", "notice"
_PART_OF = {  # name of a status in diagnostics, without the node's name space, to the part
    "voice_assist: voice": "voice",
    "rst_control: recording": "recording",
    "rst_control: control loop": "control loop",
    "rst_control: motion": "motion",
    "rst_control: settings": "settings",
    "pedal: pedal": "pedal",
}
_HEARD_BY = {"strangers of the devices": "devices"}  # a node whose only status this is
_BY_CAUSE = ("part settings", "part strangers ")  # keys whose message names who or what it is
_OWNER_OF = {"rst_control": "controller", "voice_assist": "voice", "kinova_guard": "stop guard"}


# Numbers that stand alone: not those in a name (joint_2, kinova-2) or an address (192.168.1.10).
_NUMBERS = re.compile(r"(?<![\w.])(?<!\w-)[0-9]+(?:\.[0-9]+)?(?:e[-+]?[0-9]+)?(?!\.?[0-9])")
FORGOTTEN_AFTER = (
    10.0  # [s] without a word of a part, which speaks every second: its node has ended
)


@dataclass(frozen=True)
class Standing:
    """An alarm that stands."""

    key: str  # of one key only one stands
    alarm: Alarm
    since: float  # [s]
    until: float | None = None  # [s] when it goes by itself; None: with its cause
    is_acknowledged: bool = False
    times: int = 1  # how often it was given: each asks to be heard


class Board:
    """Keeps what stands.

    Args:
        config: How long things are shown, and when silence is a fault.
        wakes: Phrases that wake the robot, and so acknowledge alarms.
        ask: What is said of a phrase that is asked for.
    """

    def __init__(
        self,
        config: BoardConfig,
        wakes: frozenset[str] = frozenset({HEY_ROBOT}),
        ask: Callable[[str], str] = lambda _: "",
    ) -> None:
        self._config, self._wakes, self._ask = config, wakes, ask
        self._limits = {  # [s] of the parts whose silence is a fault
            "voice": config.voice_silent_after,
            "controller": config.controller_silent_after,
            "pedal": config.pedal_silent_after,
            "devices": config.devices_silent_after,
        }
        self._all: dict[str, Standing] = {}
        self._robot = RobotState(0.0, "")
        self._seen: dict[str, float] = {}  # [s] last message of those that were heard
        self._errors: dict[str, tuple[str, str, float]] = {}  # message, code, time [s] of each
        self._begun: float | None = None  # [s] of the first thing taken in

    @property
    def standing(self) -> tuple[Standing, ...]:
        """All that stands, what comes first in front: by priority, then the newest."""
        order = sorted(self._all.values(), key=lambda s: (s.alarm.priority, s.since), reverse=True)
        return tuple(order)

    def see_state(self, state: RobotState, now: float) -> None:
        """Take in the controller's state at a time [s]."""
        if state.stamp != self._robot.stamp:
            self._seen["controller"] = now  # a state that stands still is no word
        before, self._robot = self._robot, state
        if state.halt_reason:
            is_new = state.halt_reason != before.halt_reason
            is_loaded = state.is_loaded or (is_new and before.is_loaded)
            self._raise(
                _LATCH, latch_alarm(state.halt_reason, state.halt_reason_code, is_loaded), now
            )
        else:
            self._all.pop(_LATCH, None)
        self._look_at_parts(now)

    def see_event(self, event: ControllerEvent, now: float) -> None:
        """Take in an entry of the controller's event log."""
        if event.command == HEY_ROBOT and event.kind in ("accepted", "refused"):
            self._acknowledge()
        if event.kind == "accepted":
            self._all.pop(_GIVE_UP, None)
        if event.kind == "stop_received" and _LATCH in self._all:
            self._again(_LATCH)  # who says "stop" must hear that it was heard
        alarm = event_alarm(event, self._robot.is_tissue_held)
        if alarm is None:
            return
        if alarm.kind is Kind.FAULT:
            self._raise(_GIVE_UP, alarm, now)
        else:
            self._flash(_REFUSAL if alarm.kind is Kind.REFUSAL else _NOTICE, alarm, now)

    def see_utterance(self, utterance: UtteranceReport, now: float) -> None:
        """Take in what the recogniser decided."""
        if utterance.command in self._wakes:
            self._acknowledge()
        alarm = unheard_alarm(utterance, self._ask)
        if alarm is not None:
            self._flash(_REFUSAL, alarm, now)

    def see_health(self, health: PartHealth, now: float) -> None:
        """Take in one status of `/diagnostics`."""
        part = _part_of(health.name.lstrip("/").rsplit("/", 1)[-1])
        if part is None:
            return
        if (node := _HEARD_BY.get(part, part)) in self._limits:
            self._seen[node] = now
        if health.is_error:
            self._errors[part] = health.message, health.reason_code, now
        else:
            self._errors.pop(part, None)
        self._look_at_parts(now)

    def tick(self, now: float) -> None:
        """Let go what has been shown long enough, and notice silence."""
        over = [k for k, s in self._all.items() if s.until is not None and now >= s.until]
        for key in over:
            del self._all[key]
        self._look_at_parts(now)

    def _look_at_parts(self, now: float) -> None:
        """Raise or drop the alarms of the parts, in the situation of this moment."""
        errors = self._part_errors(now)
        for key in [k for k in self._all if k.startswith("part ") and k[5:] not in errors]:
            del self._all[key]
        for part, (message, code) in errors.items():
            self._raise(f"part {part}", part_alarm(part, message, code, self._robot.is_loaded), now)

    def _part_errors(self, now: float) -> dict[str, tuple[str, str]]:
        """Message and code of each part with an error; to be silent is one, too."""
        self._begun = now if self._begun is None else self._begun
        is_used = self._robot.is_active or self._robot.is_loaded
        if now - self._begun < self._config.starting_for and not is_used:
            return {}
        errors = {
            part: (message, code)
            for part, (message, code, said) in self._errors.items()
            if part in self._seen or now - said <= FORGOTTEN_AFTER
        }
        for part, seen in self._seen.items():
            limit = self._limits[part]
            if now - seen > limit:
                errors[part] = f"no word for more than {limit:.1f} s", SILENT
        if _LATCH in self._all or "controller" in errors:
            errors.pop("motion", None)  # its consequence or its cause stands already
        return errors

    def _raise(self, key: str, alarm: Alarm, now: float) -> None:
        """Let an alarm stand until its cause goes; while the cause stays, it never gets milder."""
        known = self._all.get(key)
        if known is None or not _is_same(key, known.alarm, alarm):
            self._all[key] = Standing(key, alarm, now)
        elif alarm.priority > known.alarm.priority:
            worse = replace(known, alarm=alarm, is_acknowledged=False, times=known.times + 1)
            self._all[key] = worse

    def _flash(self, key: str, alarm: Alarm, now: float) -> None:
        """Show an alarm for a while; one that comes again counts."""
        known = self._all.get(key)
        times = known.times + 1 if known else 1
        self._all[key] = Standing(key, alarm, now, now + self._config.shown_for, times=times)

    def _again(self, key: str) -> None:
        known = self._all[key]
        self._all[key] = replace(known, is_acknowledged=False, times=known.times + 1)

    def _acknowledge(self) -> None:
        for key, known in self._all.items():
            self._all[key] = replace(known, is_acknowledged=True)


def wake_phrases(commands: CommandsConfig) -> frozenset[str]:
    """How "hey robot" is said: the phrases of the commands that call it."""
    return frozenset(c.phrase for c in commands.commands if c.command == HEY_ROBOT)


def _is_same(key: str, first: Alarm, second: Alarm) -> bool:
    """Whether two alarms have one cause; numbers that stand alone may change in most of them."""
    causes = first.cause, second.cause
    if key != _LATCH and not key.startswith(_BY_CAUSE):
        causes = _NUMBERS.sub("", first.cause), _NUMBERS.sub("", second.cause)
    return causes[0] == causes[1] and first.next_step == second.next_step


def _part_of(status: str) -> str | None:
    """The part that a status is of; each node may have strangers on its topics."""
    node, _, what = status.partition(": ")
    if what == "strangers":
        return f"strangers of the {_OWNER_OF.get(node, node)}"
    return _PART_OF.get(status)
