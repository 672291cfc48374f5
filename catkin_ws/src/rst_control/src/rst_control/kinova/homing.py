# SPDX-License-Identifier: BSD-3-Clause
"""Homes OpenRST: connect, calibrate, position control; each verified before the next."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future
from typing import Final

from rst_control.errors import RstError
from rst_control.kinova.tool import HOMING, Tool, ToolState
from rst_control.types import Vector

STATE_TIME: Final = 2.0  # [s] for state and joints to be reported after a request was granted
SENDING_TIME: Final = 0.1  # [s] for which a command is repeated, so that it precedes the request
Wait = Callable[[Callable[[], bool], float], bool]  # for a condition, up to so long [s]; if it held


class HomingFailed(RstError):
    """A request was refused, or left the node in another state."""

    def __init__(self, request: str, why: str) -> None:
        super().__init__(f'OpenRST did not home: "{request}" {why}')
        self.request = request


def answered(answer: Future[bool], request: str, limit: float) -> bool:
    """What the node answered to a request.

    Args:
        answer: To come.
        request: That was made.
        limit: Longest wait [s].

    Raises:
        HomingFailed: There was none within the limit.
    """
    try:
        return bool(answer.result(limit))
    except TimeoutError as error:
        why = (
            f"was not answered within {limit:g} s. Its motors may still be driven: end OpenRST's "
            "node, then see that the instrument is latched on and that its DAQ topics come"
        )
        raise HomingFailed(request, why) from error


class NotAllowed(RstError):
    """The tool may not be homed now; says why."""


def home(
    request: Callable[[str], bool],
    tool: Tool,
    send: Callable[[Vector], None],
    wait: Wait,
) -> str:
    """Bring the tool into position control, homed; its jaws and pitch move over their whole range.

    Args:
        request: Asks the node for something, and returns whether it did it; may raise this error.
        tool: What the node last said of itself.
        send: Takes pitch and jaws [rad], in the node's own signs. Shape (3,).
        wait: Waits for a condition, for so many seconds; whether it came to hold.

    Returns:
        What was done, in words.

    Raises:
        HomingFailed: Names the request and what came of it.
    """
    for name, wanted in HOMING:
        if not request(name):
            raise HomingFailed(name, "was refused")
        if not wait(lambda wanted=wanted: tool.state in wanted, STATE_TIME):  # type: ignore[misc]
            now = tool.state
            found = "reported no state" if now is None else f"left it in {now.name}"
            needed = " or ".join(one.name for one in wanted)
            raise HomingFailed(name, f"{found}, needed: {needed}")
        if ToolState.READY in wanted:
            _stay(tool, send, wait)
    return "OpenRST is homed, and in position control"


def _stay(tool: Tool, send: Callable[[Vector], None], wait: Wait) -> None:
    """Send the tool where it is: its node kept the last command, and would drive it there."""
    wait(lambda: tool.feedback is not None, STATE_TIME)
    if (seen := tool.feedback) is None:
        raise HomingFailed("calibrate", "left it in READY without joints reported")
    place = tool.command(seen.position)

    def keep_sending() -> bool:
        send(place)
        return False

    wait(keep_sending, SENDING_TIME)
