# SPDX-License-Identifier: BSD-3-Clause
"""What tests of the recorder give to it: a topic, and the error of a full disk."""

import errno
import os

from session_log.types import MessageSource


def text(topic="/t", publisher="/p"):
    return MessageSource(topic, "std_msgs/String", "992c", "string data", publisher)


def full():
    return OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
