# SPDX-License-Identifier: BSD-3-Clause
"""Clients that stop the robot, each a process and a node of its own; a pipe gives the moment."""

from __future__ import annotations

import multiprocessing
import time
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from pkgutil import extend_path

WAYS = ("service", "topic", "cancel")
CONNECT_TIME = 60.0  # [s] for all to find the controller on a loaded machine
ANSWER_TIME = 10.0  # [s] for all to have sent theirs


@dataclass(frozen=True)
class StopOrder:
    """What a client is to do."""

    way: str  # one of WAYS
    at: float  # [s] time.monotonic() at which to send


class Clients:
    """A number of nodes that send stops; a context manager.

    Args:
        count: Of clients.
    """

    def __init__(self, count: int) -> None:
        self._count = count
        self._pipes: list[Connection] = []
        self._processes: list[BaseProcess] = []

    def __enter__(self) -> Clients:
        context = multiprocessing.get_context("spawn")
        for number in range(self._count):
            ours, theirs = context.Pipe()
            process = context.Process(target=_client, args=(number, theirs), daemon=True)
            process.start()
            theirs.close()
            self._pipes.append(ours)
            self._processes.append(process)
        self._answers(self._pipes, CONNECT_TIME + self._count)
        return self

    def __exit__(self, *_: object) -> None:
        for pipe in self._pipes:
            with suppress(OSError):
                pipe.send(None)
        for process in self._processes:
            process.join(timeout=5.0)
            if process.is_alive():
                process.kill()

    def stop(self, way: str, at: list[float]) -> list[float]:
        """Let as many clients as there are times send one stop each.

        Args:
            way: One of WAYS.
            at: Times to send [s], time.monotonic().

        Returns:
            Times at which they were sent [s].

        Raises:
            RuntimeError: A client ended, or did not answer.
        """
        pipes = self._pipes[: len(at)]
        for pipe, moment in zip(pipes, at, strict=True):
            pipe.send(StopOrder(way, moment))
        return self._answers(pipes, ANSWER_TIME)

    def _answers(self, pipes: list[Connection], limit: float) -> list[float]:
        end, answers = time.monotonic() + limit, []
        for number, pipe in enumerate(pipes):
            try:
                if not pipe.poll(max(0.0, end - time.monotonic())):
                    raise RuntimeError(f"client {number} did not answer within {limit:.0f} s")
                answers.append(float(pipe.recv()))
            except (EOFError, OSError) as error:
                raise RuntimeError(f"client {number} ended") from error
        return answers


def _client(number: int, pipe: Connection) -> None:
    """One client, in its own process."""
    import rospy
    from actionlib_msgs.msg import GoalID
    from std_msgs.msg import Empty

    import rst_control

    # A spawned process finds the sources first; the messages made of them lie elsewhere.
    rst_control.__path__ = extend_path(rst_control.__path__, rst_control.__name__)
    from rst_control.srv import Command

    rospy.init_node(f"stops_client_{number}", disable_signals=True, disable_rosout=True)
    topic = rospy.Publisher("rst_control/stop", Empty, queue_size=1, tcp_nodelay=True)
    cancel = rospy.Publisher("rst_control/execute/cancel", GoalID, queue_size=1, tcp_nodelay=True)
    service = rospy.ServiceProxy("rst_control/command", Command, persistent=True)
    rospy.wait_for_service("rst_control/command", CONNECT_TIME)
    while not (topic.get_num_connections() and cancel.get_num_connections()):
        time.sleep(0.02)
    senders = {
        "service": lambda: service("stop"),
        "topic": lambda: topic.publish(Empty()),
        "cancel": lambda: cancel.publish(GoalID()),  # without an id: all goals
    }
    pipe.send(time.monotonic())
    while True:
        order: StopOrder | None = pipe.recv()
        if order is None:
            return
        time.sleep(max(0.0, order.at - time.monotonic()))
        sent = time.monotonic()
        senders[order.way]()
        pipe.send(sent)
