# SPDX-License-Identifier: BSD-3-Clause
"""From what happened to the alarm that tells it: pure functions of values.

A fault while tissue is held or the robot moves is of high priority, any other of medium; a person's
stop is of medium priority, since the robot holds; a refusal is of low. What was done as asked is
information.
"""

from __future__ import annotations

from typing import Final

from voice_assist.alarms.causes import (
    ENDED_AS_ASKED,
    GIVE_UPS,
    LATCHES,
    NO_REASON,
    PARTS,
    REFUSALS,
    UNHEARD,
    UNKNOWN,
    Cause,
    find,
)
from voice_assist.alarms.types import Alarm, DiaryEvent, Earcon, Kind, Priority, Utterance

HEY_ROBOT: Final = "hey robot"
TERMINATE: Final = "terminate"

_FAULTS: Final = {
    Priority.HIGH: Earcon.FAULT_HIGH,
    Priority.MEDIUM: Earcon.FAULT_MEDIUM,
    Priority.LOW: Earcon.FAULT_LOW,
}
_PARTS: Final = {  # priority at rest with nothing held, and while tissue is held or in motion
    "voice deaf": (Priority.MEDIUM, Priority.HIGH),
    "voice slow": (Priority.MEDIUM, Priority.HIGH),
    "voice gone": (Priority.MEDIUM, Priority.HIGH),
    "voice spotter": (Priority.LOW, Priority.LOW),  # the recogniser still hears a stop
    "controller gone": (Priority.MEDIUM, Priority.HIGH),
    "controller thread": (Priority.LOW, Priority.MEDIUM),
    "recorder lost": (Priority.LOW, Priority.MEDIUM),  # no danger by itself
    "robot unwell": (Priority.LOW, Priority.HIGH),
}


def latch_alarm(reason: str, is_loaded: bool) -> Alarm:
    """What braked the robot and latched.

    Args:
        reason: `ControllerState.halt_reason`.
        is_loaded: Tissue is held, or the robot moved when it happened.
    """
    cause = find(LATCHES, reason, UNKNOWN)
    if cause.kind is Kind.STOP:
        return Alarm(Kind.STOP, Priority.MEDIUM, reason, cause.next_step, Earcon.STOP)
    return _fault(cause, Priority.HIGH if is_loaded else Priority.MEDIUM, reason)


def event_alarm(event: DiaryEvent, is_tissue_held: bool) -> Alarm | None:
    """What an entry of the diary tells by itself; None: nothing, or the latch tells it."""
    if event.kind in ("refused", "trocar_refused"):
        cause = find(REFUSALS, event.message, NO_REASON)
        return _refusal(
            cause, f"{event.command}: {event.message}" if event.command else event.message
        )
    if event.kind == "at_rest":
        return _given_up(event, is_tissue_held)
    if event.kind == "accepted":
        return _accepted(event)
    return None


def unheard_alarm(utterance: Utterance) -> Alarm | None:
    """The words of a command that was not taken; None: other talk, which is nobody's alarm."""
    if utterance.command or not utterance.nearest or utterance.wer != 0.0:
        return None
    cause = next((cause for cause in UNHEARD if cause.fits(utterance.reason)), None)
    if cause is None:  # it denies, or fits several: then nothing is what was wanted
        return None
    return _refusal(cause, f"{utterance.nearest}: {utterance.reason}")


def part_alarm(part: str, message: str, is_loaded: bool) -> Alarm:
    """A part that reports an error, or has fallen silent.

    Args:
        part: voice, controller, recording, control loop or motion.
        message: What it says, or how long it has said nothing.
        is_loaded: Tissue is held, or the robot moves.
    """
    words = f"{part}: {message}"
    cause = find(PARTS, words, UNKNOWN)
    at_rest, loaded = _PARTS.get(cause.name, (Priority.MEDIUM, Priority.HIGH))
    return _fault(cause, loaded if is_loaded else at_rest, words)


def _given_up(event: DiaryEvent, is_tissue_held: bool) -> Alarm | None:
    if event.message == ENDED_AS_ASKED:
        return None
    cause = next((cause for cause in GIVE_UPS if cause.fits(event.message)), None)
    if cause is None:  # it came to rest towards a latch, which has its own alarm
        return None
    words = f"{event.command}: {event.message}"
    return _fault(cause, Priority.MEDIUM if is_tissue_held else Priority.LOW, words)


def _accepted(event: DiaryEvent) -> Alarm:
    step, earcon = 'Say "stop" to stop it.', Earcon.ACCEPTED
    if event.command == HEY_ROBOT:
        step, earcon = "Say a command.", Earcon.ARMED
    elif event.command == TERMINATE:
        step, earcon = 'Say "hey robot" to go on.', Earcon.STANDBY
    words = f"{event.command}: {event.message}" if event.message else event.command
    return Alarm(Kind.NOTICE, Priority.INFORMATION, words, step, earcon)


def _fault(cause: Cause, priority: Priority, words: str) -> Alarm:
    return Alarm(Kind.FAULT, priority, words, cause.next_step, _FAULTS[priority])


def _refusal(cause: Cause, words: str) -> Alarm:
    return Alarm(Kind.REFUSAL, Priority.LOW, words, cause.next_step, Earcon.REFUSAL)
