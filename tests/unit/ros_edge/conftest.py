# SPDX-License-Identifier: BSD-3-Clause
"""Generated messages can be imported here, which pytest's paths hide; the log is kept."""

from pkgutil import extend_path

import pytest
import rospy.rostime

import rst_control
import voice_assist

for package in (rst_control, voice_assist):
    package.__path__ = extend_path(package.__path__, package.__name__)

rospy.rostime.set_rostime_initialized(True)  # there is no node that would do it


@pytest.fixture
def logged(monkeypatch):
    """Words that were logged, whatever their level."""
    logged = []
    for level in ("loginfo", "logwarn", "logerr", "logfatal"):
        monkeypatch.setattr(rospy, level, lambda words, *parts: logged.append(words % parts))
    return logged
