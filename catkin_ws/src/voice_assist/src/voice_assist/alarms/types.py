# SPDX-License-Identifier: BSD-3-Clause
"""What alarms are made of, and what they are made from; nothing here knows ROS."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import Enum, IntEnum

IN_MOTION = ("moving", "stopping")  # states of the controller


class Priority(IntEnum):
    """How soon somebody has to act; the numbers are those of `Alarm.msg`."""

    INFORMATION = 0  # nobody has to
    LOW = 1  # to be aware
    MEDIUM = 2  # soon: the robot holds
    HIGH = 3  # at once: tissue is held, or the robot was in motion


class Kind(Enum):
    """What an alarm is about; the values are those of `Alarm.msg`."""

    STOP = "stop"  # a person or a program stopped the robot
    FAULT = "fault"  # something failed
    REFUSAL = "refusal"  # a command is not carried out
    NOTICE = "notice"  # no alarm: something was done as asked


class Earcon(Enum):
    """A sound; the value names its file and its row in the documentation."""

    FAULT_HIGH = "fault-high"
    FAULT_MEDIUM = "fault-medium"
    FAULT_LOW = "fault-low"
    STOP = "stop"
    REFUSAL = "refusal"
    QUESTION = "question"
    ACCEPTED = "accepted"
    ARMED = "armed"
    STANDBY = "standby"


@dataclass(frozen=True)
class AlarmText:
    """What a person reads."""

    kind: Kind
    priority: Priority
    cause: str  # as the part that noticed it gave it
    next_step: str  # one short sentence that says what to do


@dataclass(frozen=True)
class Alarm(AlarmText):
    """What a person reads and hears."""

    earcon: Earcon
    answer: str = ""  # sentence of `answers.sentences` that may be said of it

    def said_in(self, texts: Callable[[str], str]) -> Alarm:
        """The same in another language: what to do, and why in brief; the details stay English.

        Args:
            texts: A sentence in that language, by the English one.
        """
        why, step = texts(self.answer), texts(self.next_step)
        cause = f"{why}: {self.cause}" if why != self.answer else self.cause
        return replace(self, cause=cause, next_step=step, answer=why)


@dataclass(frozen=True)
class RobotState:
    """What the controller says of itself, 50 times a second."""

    stamp: float  # [s] of the controller's loop; it stands still where that does
    state: str  # standby, active, moving, stopping, halted or faulted
    halt_reason: str = ""  # why it is latched or brakes towards a latch; empty: it is not
    halt_reason_code: str = ""
    is_active: bool = False
    is_tissue_held: bool = False

    @property
    def is_loaded(self) -> bool:
        """Tissue is held, or the robot moves: what fails now is urgent."""
        return self.is_tissue_held or self.state in IN_MOTION


@dataclass(frozen=True)
class ControllerEvent:
    """An entry of the controller's event log."""

    kind: str
    command: str
    message: str
    reason_code: str = ""


@dataclass(frozen=True)
class UtteranceReport:
    """What the recogniser decided of an utterance."""

    command: str  # empty: none
    reason: str  # why none was taken
    reason_code: str
    nearest_command: str  # that which sounds most alike
    wer: float  # of that command


@dataclass(frozen=True)
class PartHealth:
    """One status of `/diagnostics`."""

    name: str
    is_error: bool
    message: str
    reason_code: str = ""  # of the error
