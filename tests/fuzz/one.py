# SPDX-License-Identifier: BSD-3-Clause
"""Fuzz one target: `python -m tests.fuzz.one <target> [arguments of libFuzzer]`."""

import sys

import atheris

READERS = (
    *(
        "rst_control.admission.command_queue",
        "rst_control.admission.callers",
        "rst_control.ros.rospy_patches.message_framing",
        "rst_control.ros.rospy_patches.message_limits",
    ),
    *(
        "rst_control.ros.common.serialization",
        "rst_control.ros.controller.services.command_service",
        "rst_control.msg",
    ),
    *(
        "rst_control.srv",
        "voice_assist.text.normalize",
        "voice_assist.intent.mapper",
        "voice_assist.text.wer",
    ),
    *("voice_assist.msg", "voice_assist.ros.topic_source", "voice_assist.audio.source"),
    *("rosgraph.network", "sensor_msgs", "std_msgs", "actionlib_msgs", "tests.fuzz.targets"),
)

with atheris.instrument_imports(include=list(READERS)):
    from tests.fuzz.targets import TARGETS


def main():
    """Fuzz until libFuzzer ends the process."""
    name = sys.argv.pop(1)
    atheris.Setup(sys.argv, TARGETS[name])
    atheris.Fuzz()


if __name__ == "__main__":
    main()
