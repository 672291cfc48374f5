# SPDX-License-Identifier: BSD-3-Clause
"""What every controller has that runs in one process with its robot: commands, and time to pass."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from rst_control.admission.command_queue import CommandQueue, PendingCommand
from rst_control.execution.executor import Executor
from rst_control.kinematics import forward
from rst_control.kinematics.configuration import Configuration, planning_joints
from rst_control.planning.planner import Planner
from rst_control.types import IN_MOTION

Array = NDArray[np.float64]
START = 10.0  # [s] time of the first state
AT_ONCE = ("hey robot", "stop", "terminate")
PATIENCE = 90.0  # [s] for a command to be carried out


def do_nothing() -> None:
    """What is done after a step where nothing is."""


class LockStep(ABC):
    """Time goes on only by `tick`; a context manager. A subclass makes the parts."""

    executor: Executor
    queue: CommandQueue
    planner: Planner
    period: float  # [s] of the control loop
    robot: Any  # the simulation, with `reading` and `close`

    @abstractmethod
    def tick(self, each: Callable[[], None] = do_nothing) -> None:
        """One period of the control loop; `each` is called after every step of the physics."""

    def run(self, seconds: float) -> None:
        """Let time pass."""
        for _ in range(round(seconds / self.period)):
            self.tick()

    def until(
        self,
        condition: Callable[[], bool],
        limit: float = PATIENCE,
        each: Callable[[], None] = do_nothing,
    ) -> bool:
        """Tick until the condition holds; False where it did not within `limit` [s]."""
        for _ in range(round(limit / self.period)):
            if condition():
                return True
            self.tick(each)
        return False

    def give(
        self,
        words: str,
        tension: float = 0.0,
        distance: float = 0.0,
        is_spoken: bool = False,
        owner: str = "",
    ) -> PendingCommand:
        """Give a command and tick until it is answered; `CommandQueue.take` says what each is."""
        pending = self.queue.take(
            words, "bench", is_spoken, not is_spoken, None, owner, tension, distance
        )
        while not pending.reply.done():
            waiting = None if words in AT_ONCE else self.queue.next(0.0)
            if waiting is not None:
                self.queue.check(waiting)
            self.tick()
        return pending

    def finish(
        self,
        words: str,
        tension: float = 0.0,
        distance: float = 0.0,
        each: Callable[[], None] = do_nothing,
    ) -> str:
        """Give a command and carry it out; returns what went wrong, or an empty string."""
        pending = self.give(words, tension, distance)
        if not pending.reply.result(0).accepted:
            return f"refused: {pending.reply.result(0).message}"
        if not self.until(pending.ended.done, each=each):
            return "never ended"
        outcome = pending.ended.result(0)
        return "" if outcome.kind == "succeeded" else f"{outcome.kind}: {outcome.message}"

    @property
    def is_moving(self) -> bool:
        """The controller carries out a command, or brakes."""
        return self.executor.snapshot.mode.state in IN_MOTION

    def tip_at(self, joints: Array) -> Array:
        """Tool tip at robot joints (10,) [rad]: base frame, [m]. Shape (3,)."""
        q, _ = planning_joints(joints)
        return Configuration(self.planner.model, q).frames[forward.TIP, :, 3]

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.robot.close()
