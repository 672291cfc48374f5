# SPDX-License-Identifier: BSD-3-Clause
"""Fuzz one target: `python -m tests.fuzz.one <target> [arguments of libFuzzer]`."""

import sys

import atheris

READERS = (
    *("rst_control.desk", "rst_control.callers", "rst_control.intake", "rst_control.ros.intake"),
    *("rst_control.ros.wire", "rst_control.ros.command_service", "rst_control.msg"),
    *("rst_control.srv", "voice_assist.normalize", "voice_assist.mapper", "voice_assist.wer"),
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
