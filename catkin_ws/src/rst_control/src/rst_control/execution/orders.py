# SPDX-License-Identifier: BSD-3-Clause
"""A verified command on its way to the executor, its answer and how its motion ended."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Final, Literal

from rst_control.commands.request import Plan
from rst_control.commands.spec import CommandSpec
from rst_control.types import Cause, Reason

OUTRUN: Final = "stopped meanwhile; say it again"  # of what was given before the robot was latched
GIVEN_UP: Final = Cause(Reason.WITHDRAWN, "its caller no longer waits for an answer")
OutcomeKind = Literal["succeeded", "refused", "stopped", "failed"]


@dataclass(frozen=True)
class Reply:
    """Answer to a command, in words for people."""

    accepted: bool
    message: str
    reason: Reason | None = None  # None: accepted

    def __post_init__(self) -> None:
        if self.accepted is not (self.reason is None):
            raise ValueError(f"accepted: {self.accepted}, with the reason {self.reason}")

    @classmethod
    def refused(cls, cause: Cause) -> Reply:
        """That the command is not carried out."""
        return cls(False, cause.words, cause.reason)


@dataclass(frozen=True)
class Outcome:
    """How a motion ended."""

    kind: OutcomeKind
    message: str  # why it did not succeed; empty: it did
    reason: Reason | None = None  # None: it succeeded
    tension: float = 0.0  # [N] at the end
    max_rcm_error: float = 0.0  # [m] largest measured in motion

    def __post_init__(self) -> None:
        if (self.kind == "succeeded") is not (self.reason is None):
            raise ValueError(f"outcome {self.kind} with the reason {self.reason}")


def _ignore(_: object) -> None:
    """Report to nobody."""


def _is_wanted() -> bool:
    return True


@dataclass(frozen=True, eq=False)
class Order:
    """A verified command on its way to the executor, with those who want to hear of it."""

    plan: Plan
    serial: int  # of the view in which it was verified
    latches: int  # of the executor, when it was given
    is_spoken: bool = False  # it came from the voice node, whose heartbeat must go on
    owner: str = ""  # node whose loss brakes the motion; empty: it may leave
    caller: str = ""  # node that asked, for the event log
    claim: Callable[[], bool] = field(default=_is_wanted)  # False: the caller has given it up
    reply: Callable[[Reply], None] = field(default=_ignore)
    stale: Callable[[], None] | None = None  # instead of the reply, after a change of the view
    started: Callable[[], None] = field(default=lambda: None)  # once its motion has set off
    ended: Callable[[Outcome], None] = field(default=_ignore)

    @property
    def command(self) -> CommandSpec:
        """Which command it is."""
        return self.plan.command
