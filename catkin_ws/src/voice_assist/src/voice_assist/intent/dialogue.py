# SPDX-License-Identifier: BSD-3-Clause
"""What a recognised command does to the voice mode, and what it asks of the robot."""

from __future__ import annotations

from dataclasses import dataclass

from voice_assist.config import CommandConfig
from voice_assist.types import Action, Call, Halt, Mode, Rejection, RejectionReason, SetMode


@dataclass(frozen=True)
class DialogueState:
    """All that the dialogue remembers."""

    mode: Mode
    reason: str  # the command or event that set the mode


@dataclass(frozen=True)
class CommandRecognized:
    """A command was recognised."""

    command: CommandConfig


@dataclass(frozen=True)
class Answered:
    """The controller answered a call."""

    command: str
    is_accepted: bool
    message: str


@dataclass(frozen=True)
class ModeReported:
    """The robot's own mode, where no word of the voice is on its way to it."""

    mode: Mode


@dataclass(frozen=True)
class DialogueStep:
    """Outcome of one event."""

    state: DialogueState
    actions: tuple[Action, ...]  # to be done in this order
    rejection: Rejection | None = None  # why a command is not taken; None: it is


AT_START = DialogueState(Mode.STANDBY, "start")


def step(state: DialogueState, event: CommandRecognized | Answered | ModeReported) -> DialogueStep:
    """Next state and what to do; pure.

    A command counts only in its modes. A refusal by the controller is written into the reason; the
    mode stays as the spoken word set it until the robot reports another. Its mode is also set by
    hand, pedal and action.
    """
    if isinstance(event, ModeReported):
        return _reported(state, event.mode)
    if isinstance(event, Answered):
        return _answered(state, event)
    command = event.command
    if state.mode.value not in command.modes:
        return DialogueStep(state, (), _wrong_mode(command, state.mode))
    actions: list[Action] = [Halt()] if command.is_halt else []
    if command.command:
        actions.append(Call(command.command))
    mode = state.mode if command.mode_after == "same" else Mode(command.mode_after)
    if mode is state.mode:
        return DialogueStep(state, tuple(actions))
    return DialogueStep(
        DialogueState(mode, command.phrase), (*actions, SetMode(mode, command.phrase))
    )


def _answered(state: DialogueState, event: Answered) -> DialogueStep:
    if event.is_accepted or state.reason != event.command:
        return DialogueStep(state, ())
    reason = f"{event.command}, refused by the robot: {event.message}"
    return DialogueStep(DialogueState(state.mode, reason), (SetMode(state.mode, reason),))


def _reported(state: DialogueState, mode: Mode) -> DialogueStep:
    if mode is state.mode:
        return DialogueStep(state, ())
    reason = f"{mode.value} at the robot"
    return DialogueStep(DialogueState(mode, reason), (SetMode(mode, reason),))


def _wrong_mode(command: CommandConfig, mode: Mode) -> Rejection:
    allowed = " or ".join(command.modes)
    words = f"{command.phrase!r} counts only in {allowed} mode, and the mode is {mode.value}"
    is_asleep = mode is Mode.STANDBY
    reason = RejectionReason.WRONG_MODE if is_asleep else RejectionReason.OTHER_MODE
    return Rejection(reason, words)
