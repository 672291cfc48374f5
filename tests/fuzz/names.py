# SPDX-License-Identifier: BSD-3-Clause
"""Names of the targets, apart from them: importing those loads all that is fuzzed."""

NAMES = (
    "joint_states",
    "tension",
    "messages",
    "stream",
    "handshake",
    "queue",
    "mapper",
    "callers",
    "sound",
)
