# SPDX-License-Identifier: BSD-3-Clause
"""How rospy sends what this process publishes."""

from __future__ import annotations

import rospy.topics

from rst_control.outflow import PromptConnection


def send_promptly() -> None:
    """Publish without a thread per subscriber; call it before the first publisher is made."""
    rospy.topics.QueuedConnection = PromptConnection
