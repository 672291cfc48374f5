# SPDX-License-Identifier: BSD-3-Clause
"""From what happened to its alarm: pure functions of values.

A fault while tissue is held or the robot moves is of high priority, any other of medium; a person's
stop is of medium priority, since the robot holds; a refusal is of low. What was done as asked is
information.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Final

from voice_assist.alarms.causes import (
    GIVE_UPS,
    LATCHES,
    NO_REASON,
    REFUSALS,
    UNHEARD,
    UNKNOWN,
    Advice,
    part_advice,
)
from voice_assist.alarms.types import (
    Alarm,
    ControllerEvent,
    Earcon,
    Kind,
    Priority,
    UtteranceReport,
)
from voice_assist.answers.sentences import taken, why

HEY_ROBOT: Final = "hey robot"
TERMINATE: Final = "terminate"

_FAULTS: Final = {
    Priority.HIGH: Earcon.FAULT_HIGH,
    Priority.MEDIUM: Earcon.FAULT_MEDIUM,
    Priority.LOW: Earcon.FAULT_LOW,
}


def latch_alarm(reason: str, code: str, is_loaded: bool) -> Alarm:
    """What braked the robot and latched.

    Args:
        reason: `ControllerState.halt_reason`.
        code: `ControllerState.halt_reason_code`.
        is_loaded: Tissue is held, or the robot moved when it happened.
    """
    advice = LATCHES.get(code, UNKNOWN)
    if advice.kind is Kind.STOP:
        return Alarm(Kind.STOP, Priority.MEDIUM, reason, advice.next_step, Earcon.STOP)
    return _fault(advice, is_loaded, reason, why(code))


def event_alarm(event: ControllerEvent, is_tissue_held: bool) -> Alarm | None:
    """The alarm of an event by itself; None: none, or that of the latch."""
    words = f"{event.command}: {event.message}" if event.command else event.message
    if event.kind in ("refused", "trocar_refused", "grasp_refused"):
        return _refusal(REFUSALS.get(event.reason_code, NO_REASON), words, why(event.reason_code))
    if event.kind == "at_rest":
        advice = GIVE_UPS.get(event.reason_code)
        if advice is None:
            return None
        return _fault(advice, is_tissue_held, words, why(event.reason_code))
    if event.kind == "accepted":
        return _accepted(event)
    return None


def unheard_alarm(
    utterance: UtteranceReport, ask: Callable[[str], str] = lambda _: ""
) -> Alarm | None:
    """A question, or the words of a command that was not taken; None: talk is nobody's alarm.

    Args:
        utterance: What the recogniser decided.
        ask: What is said of a phrase that is asked for.
    """
    is_question = utterance.reason_code == "nearly_sure"  # what sounds almost like it, too
    is_near = utterance.nearest_command and (utterance.wer == 0.0 or is_question)
    if utterance.command or not is_near:
        return None
    advice = UNHEARD.get(utterance.reason_code)
    if advice is None:  # it denies, or fits several: then nothing is what was wanted
        return None
    code, words = utterance.reason_code, f"{utterance.nearest_command}: {utterance.reason}"
    if not is_question:
        return _refusal(advice, words, why(code))
    alarm = _refusal(advice, words, ask(utterance.nearest_command))
    return replace(alarm, earcon=Earcon.QUESTION, priority=Priority.INFORMATION)


def part_alarm(part: str, message: str, code: str, is_loaded: bool) -> Alarm:
    """A part that reports an error, or has fallen silent.

    Args:
        part: Such as voice, controller, recording or strangers of the robot.
        message: What it says, or how long it has said nothing.
        code: Of its status, or SILENT.
        is_loaded: Tissue is held, or the robot moves.
    """
    return _fault(part_advice(part, code), is_loaded, f"{part}: {message}")


def _accepted(event: ControllerEvent) -> Alarm:
    step, earcon = 'Say "stop" to stop it.', Earcon.ACCEPTED
    if event.command == HEY_ROBOT:
        step, earcon = "Say a command.", Earcon.ARMED
    elif event.command == TERMINATE:
        step, earcon = 'Say "hey robot" to go on.', Earcon.STANDBY
    words = f"{event.command}: {event.message}" if event.message else event.command
    return Alarm(Kind.NOTICE, Priority.INFORMATION, words, step, earcon, taken(event.command))


def _fault(advice: Advice, is_loaded: bool, words: str, answer: str = "") -> Alarm:
    priority = advice.loaded if is_loaded else advice.at_rest
    return Alarm(Kind.FAULT, priority, words, advice.next_step, _FAULTS[priority], answer)


def _refusal(advice: Advice, words: str, answer: str) -> Alarm:
    step = advice.next_step
    return Alarm(Kind.REFUSAL, Priority.LOW, words, step, Earcon.REFUSAL, answer)
