# SPDX-License-Identifier: BSD-3-Clause
"""Lets the tests of this folder import generated messages, which pytest's paths hide."""

from pkgutil import extend_path

import rospy.rostime

import rst_control
import voice_assist

for package in (rst_control, voice_assist):
    package.__path__ = extend_path(package.__path__, package.__name__)

rospy.rostime.set_rostime_initialized(True)  # there is no node that would do it
