# SPDX-License-Identifier: BSD-3-Clause
"""What pressed and released inputs come to; one person's foot, one device."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, replace
from typing import Final, TypeGuard

from voice_assist.config.pedal import BindingConfig, PedalConfig

STOP: Final = "stop"
SETTLED: Final = 0.05  # [s] released before a press commands: a bouncing contact presses once
RELEASED: Final = 0.8  # of `above`: an axis that commands is released only below it
# [s] after a stop no other command: one foot on two switches presses both, the second some ms later
STOP_ALONE: Final = 0.3


@dataclass(frozen=True)
class Send:
    """Send a command; a stop goes by the stop topic first."""

    command: str
    input: str
    why_not: str = ""  # why it is dropped after all; empty: it is not. A stop never is


@dataclass(frozen=True)
class Brake:
    """Stop the robot, as the dead-man is not pressed, or nobody knows whether a stop is."""

    why: str


PedalAction = Send | Brake


class Pedals:
    """Follows one device.

    Args:
        config: What each input does.
        clock: Steady time [s].
    """

    def __init__(self, config: PedalConfig, clock: Callable[[], float] = time.monotonic) -> None:
        self._bindings: Mapping[str, BindingConfig] = {b.input: b for b in config.bindings}
        self._clock = clock
        self._pressed: dict[str, bool] = {}  # without what is unknown since the device was found
        self._released_at: dict[str, float] = {}  # [s] by input
        self._stopped_at = -math.inf  # [s] when the last stop was due
        self._named: set[str] = set()
        self._gate = next((b for b in config.bindings if b.does in ("talk", "mute")), None)
        self._dead_man = next((b for b in config.bindings if b.does == "dead_man"), None)
        self.is_there = False
        self.remarks: list[str] = []  # what is wrong with the device's news, each once

    def found(self) -> None:
        """The device is there; what is pressed already, but for stop and mute, needs a release."""
        self.is_there = True
        self._pressed.clear()

    def lost(self, why: str) -> tuple[PedalAction, ...]:
        """The device is gone: nothing is pressed any more."""
        was_held = self.is_held
        self.is_there = False
        self._pressed.clear()
        if not was_held:
            return ()
        return self._with_stops_alone(Brake(f"the dead-man's device is lost: {why}"))

    def events_lost(self, why: str) -> tuple[PedalAction, ...]:
        """The device is let go of, as some of its news are lost, perhaps a tap of a stop."""
        actions = self.lost(why)
        if all(binding.command != STOP for binding in self._bindings.values()):
            return actions
        return self._with_stops_alone(Brake(f"{why}; a stop may have been among them"))

    def take(self, values: Mapping[str, float], trouble: str = "") -> tuple[PedalAction, ...]:
        """News of some inputs, by name, such as "button 2".

        Args:
            values: As the device gives them; of a button 0 or 1.
            trouble: Why they are too old to permit anything; empty: they are not.
        """
        was_held = self.is_held
        actions: list[PedalAction] = []
        for name, value in values.items():
            binding = self._bindings.get(name)
            if binding is None:
                if value and name.startswith("button"):
                    self._remark(name, f"{name} does nothing: pedal.yaml does not name it")
                continue
            if not math.isfinite(value):
                state = "pressed" if binding.does == "mute" else "released"
                self._remark(name, f"{name} gives {value}, no number: it counts as {state}")
            actions += self._change(binding, self.presses(name, value))
        if trouble:
            if was_held and self.is_held:
                actions.append(Brake(f"the dead-man is not known: {trouble}"))
            self._forget_permissions()
        return self._with_stops_alone(*actions)

    def check(self, present: Collection[str]) -> None:
        """Name the inputs of the settings that a device does not have."""
        for name in self._bindings:
            if name not in present:
                self._remark(name, f"the device has no {name}, which pedal.yaml names")

    def _change(self, binding: BindingConfig, is_pressed: bool) -> tuple[PedalAction, ...]:
        was_pressed = self._pressed.get(binding.input)
        is_safe = binding.command == STOP or binding.does == "mute"
        if was_pressed is None and is_pressed and not is_safe:
            return ()  # pressed from the start: a foot that rests there, or a stuck switch
        self._pressed[binding.input] = is_pressed
        if was_pressed is not False and not is_pressed:
            self._released_at[binding.input] = self._clock()
        if is_pressed and not was_pressed and binding.does == "command":
            if binding.command != STOP and not self._has_settled(binding):
                return ()
            return (Send(binding.command, binding.input),)
        if was_pressed and not is_pressed and binding.does == "dead_man":
            return (Brake(f"the dead-man ({binding.input}) is released"),)
        return ()

    def _forget_permissions(self) -> None:
        """What lets voice count or the robot move is unknown until news in time say so."""
        for binding in self._bindings.values():
            permits = binding.does != "mute"
            if binding.command != STOP and self._pressed.get(binding.input) is permits:
                del self._pressed[binding.input]

    def _with_stops_alone(self, *actions: PedalAction) -> tuple[PedalAction, ...]:
        """Drop every other command that comes with a stop, in any order, or just after one."""
        why_not = ""
        if not all(map(_is_droppable, actions)):
            self._stopped_at, why_not = self._clock(), "a stop came with it"
        elif actions and self._clock() - self._stopped_at < STOP_ALONE:
            why_not = "a stop came just before it"
        return tuple(replace(a, why_not=why_not) if _is_droppable(a) else a for a in actions)

    def _has_settled(self, binding: BindingConfig) -> bool:
        return self._clock() - self._released_at[binding.input] >= SETTLED

    def presses(self, name: str, value: float) -> bool:
        """Whether a value presses an input that the settings name, from its present state."""
        binding = self._bindings[name]
        if not math.isfinite(value):
            return binding.does == "mute"
        if binding.input.startswith("button"):
            return bool(value)
        limit = binding.above
        is_free = self._pressed.get(binding.input) is False
        if binding.does == "command" and binding.command != STOP and not is_free:
            limit *= RELEASED
        return value >= limit if limit > 0.0 else value <= limit

    def state(self, name: str) -> bool | None:
        """Whether an input is pressed; None: it is not known."""
        return self._pressed.get(name)

    def _remark(self, name: str, words: str) -> None:
        if name not in self._named:
            self._named.add(name)
            self.remarks.append(words)

    @property
    def has_gate(self) -> bool:
        """A pedal decides whether voice counts."""
        return self._gate is not None

    @property
    def may_talk(self) -> bool:
        """Voice counts; where device or position is unknown it does not, but for "stop"."""
        if self._gate is None:
            return True
        is_pressed = self._pressed.get(self._gate.input)
        return self.is_there and is_pressed is (self._gate.does == "talk")

    @property
    def has_dead_man(self) -> bool:
        """The robot may move only while a pedal is pressed."""
        return self._dead_man is not None

    @property
    def is_held(self) -> bool:
        """The dead-man is pressed."""
        return self._dead_man is not None and self._pressed.get(self._dead_man.input, False)


def _is_droppable(action: PedalAction) -> TypeGuard[Send]:
    return isinstance(action, Send) and action.command != STOP
