# SPDX-License-Identifier: BSD-3-Clause
"""What the robot may do while nobody records it: what eases or leaves, but nothing that loads.

A lost recording is no danger by itself, so it never stops the way back: tissue that is held can be
released or pulled less, and the tool can leave the patient.
`docs/reference/recording.md` has the reasons.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Final

from rst_control.admission.command_queue import Verify
from rst_control.commands import spec
from rst_control.commands.request import Accepted, Plan, Request, Situation
from rst_control.commands.spec import CommandSpec, Load
from rst_control.commands.table import COMMANDS
from rst_control.config.recording import IGNORE, REFUSE, STOP, RecordingConfig
from rst_control.types import Cause, Reason, Rejected

CONSEQUENCE: Final = {
    IGNORE: "ignored, as it was set",
    REFUSE: "what moves is finished, new motion is refused",
    STOP: "what loads the patient brakes, new motion is refused",
}
NEVER: Final = "no recorder was ever heard"
LASTING: Final = 1.0  # [s] that a loss lasts before the screen shows it; refusals are at once
REMEDY: Final = "start launch/record.launch, or set controller/recording/on_loss to ignore"


@dataclass(frozen=True)
class Beat:
    """Newest heartbeat of a recorder."""

    time: float  # [s] of arrival
    problem: str  # why it records nothing; empty: it records


class RecordingWatch:
    """Knows from the recorders' heartbeats whether what happens is being recorded.

    One healthy recorder is enough, however many others have lost theirs.

    Args:
        config: What a loss means.
        clock: Time [s], the same as that of the heartbeats.
    """

    def __init__(self, config: RecordingConfig, clock: Callable[[], float]) -> None:
        self._config, self._clock = config, clock
        self._beats: dict[str, Beat] = {}

    def heard(self, recorder: str, problem: str) -> None:
        """Note a heartbeat; from any thread.

        Args:
            recorder: Name of the node that sent it.
            problem: Why it records nothing; empty: it records.
        """
        self._beats[recorder] = Beat(self._clock(), problem)

    def lost(self, recorder: str, words: str) -> None:
        """Note what has become of a recorder, unless it said itself why it records nothing."""
        beat = self._beats.get(recorder)
        if beat is None or not beat.problem:
            self.heard(recorder, f"recorder {words}")

    @property
    def was_heard(self) -> bool:
        """There is a recorder, or there was one."""
        return bool(self._beats)

    @property
    def is_ignored(self) -> bool:
        """A loss changes nothing: so it was set."""
        return self._config.on_loss == IGNORE

    @property
    def consequence(self) -> str:
        """What a loss leads to, in words."""
        return CONSEQUENCE[self._config.on_loss]

    @property
    def problem(self) -> str:
        """Why nothing is being recorded at this moment; empty: it is."""
        beats = dict(self._beats)
        if not beats:
            return NEVER if self.is_ignored else f"{NEVER}; {REMEDY}"
        found = {name: self._problem(beat) for name, beat in beats.items()}
        if not all(found.values()):
            return ""
        newest = max(beats, key=lambda name: beats[name].time)
        return f"{newest}: {found[newest]}"

    def refusal(self, command: CommandSpec) -> Rejected | None:
        """Why a command must not begin now, as far as the recording goes; None: it may."""
        if self.is_ignored or command.load is not Load.LOADS:
            return None
        problem = self.problem
        easing = [c.phrase for c in COMMANDS.values() if c.load is Load.EASES]
        remaining = ", ".join(f'"{phrase}"' for phrase in (*easing, spec.STOP))
        words = f"not recorded: {problem}; still allowed: {remaining}"
        return Rejected(Reason.NOT_RECORDED, words) if problem else None

    def stop_cause(self, plan: Plan | None) -> Cause | None:
        """Why the motion under way has to brake, as far as the recording goes; None: it goes on.

        Args:
            plan: Of the motion; None at rest.
        """
        if self._config.on_loss != STOP or plan is None or plan.command.load is not Load.LOADS:
            return None
        problem = self.problem
        return Cause(Reason.NOT_RECORDED, f"not recorded: {problem}") if problem else None

    def _problem(self, beat: Beat) -> str:
        age, allowed = self._clock() - beat.time, self._config.heartbeat_age
        if age <= allowed:
            return beat.problem
        last = f", after: {beat.problem}" if beat.problem else ""
        return f"recorder silent for {age:.1f} s, allowed {allowed:.1f} s{last}"


class RecordedOnly:
    """Verification that also asks for a recording.

    It asks last, once the path is planned: as shortly before the start as can be. A command
    that is refused anyway gets the reason that lies nearer.

    Args:
        verify: Decides everything else.
        watch: Knows of the recording.
    """

    def __init__(self, verify: Verify, watch: RecordingWatch) -> None:
        self._verify, self._watch = verify, watch

    def __call__(self, request: Request, situation: Situation) -> Accepted | Rejected:
        """Decide; a motion that eases the load goes ahead, and says that it is not recorded."""
        decision = self._verify(request, situation)
        if isinstance(decision, Rejected):
            return decision
        plan = decision.plan
        refusal = self._watch.refusal(plan.command)
        if refusal is not None:
            return refusal
        if self._watch.is_ignored or plan.command.load is not Load.EASES:
            return decision
        problem = self._watch.problem
        words = f"{plan.words}; not recorded: {problem}" if problem else plan.words
        return Accepted(replace(plan, words=words))


class RecordingNews:
    """Says each change of the recording once: worse, better, or not wanted.

    A loss has to last: at the end of a launch the recorder ends a moment before the others.

    Args:
        watch: Knows of the recording.
        grace: Time [s] from the first call in which a recorder that is still starting is no news.
        clock: Time [s].
    """

    def __init__(self, watch: RecordingWatch, grace: float, clock: Callable[[], float]) -> None:
        self._watch, self._grace, self._clock = watch, grace, clock
        self._since: float | None = None
        self._is_lost: bool | None = None  # None: nothing was said yet
        self._gone: float | None = None  # [s] since when what was recorded is not

    def next(self) -> tuple[bool, str] | None:
        """What has changed since the last call, with whether it is a loss; None: nothing."""
        now = self._clock()
        self._since = now if self._since is None else self._since
        problem = self._watch.problem
        is_lost = bool(problem)
        may_start = not self._watch.was_heard and not self._watch.is_ignored
        is_starting = may_start and now - self._since < self._grace
        if is_lost is self._is_lost or is_starting:
            self._gone = None
            return None
        if is_lost and self._is_lost is False:
            self._gone = now if self._gone is None else self._gone
            if now - self._gone < LASTING:
                return None
        was_lost, self._is_lost = self._is_lost, is_lost
        if not is_lost:
            return (False, "recorded again") if was_lost else (False, "recorded")
        return True, f"not recorded: {problem}; {self._watch.consequence}"
