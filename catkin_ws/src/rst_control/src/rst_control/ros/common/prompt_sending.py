# SPDX-License-Identifier: BSD-3-Clause
"""How rospy sends what this process publishes."""

from __future__ import annotations

import time
from collections.abc import Callable

import rospy.topics

from rst_control.host.prompt_connection import PromptConnection

LAST_TIMES, LAST_PERIOD = 5, 0.02  # that a last message is sent, and [s] between them


def send_promptly() -> None:
    """Publish without a thread per subscriber; call it before the first publisher is made."""
    rospy.topics.QueuedConnection = PromptConnection


def send_in_the_end(send: Callable[[], None]) -> None:
    """Send what must arrive before this process ends, more than once."""
    for _ in range(LAST_TIMES):
        send()
        time.sleep(LAST_PERIOD)
