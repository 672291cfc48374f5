#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Simulated devices of a theatre: a light, an insufflator in steps, an endoscope's recorder.

They serve what `config/devices.yaml` calls (docs/devices.md), and publish how they stand.
"""

from __future__ import annotations

import rospy
from std_msgs.msg import Bool, Float64
from std_srvs.srv import SetBool, SetBoolRequest, SetBoolResponse, Trigger, TriggerResponse

STEP, LOWEST, HIGHEST = 1.0, 8.0, 15.0  # [mmHg]


class Theatre:
    """All three."""

    def __init__(self) -> None:
        self.pressure = 12.0
        latched = {"queue_size": 1, "latch": True}
        self.light = rospy.Publisher("/theatre/light/state", Bool, **latched)
        self.gas = rospy.Publisher("/theatre/insufflator/pressure", Float64, **latched)
        self.recorder = rospy.Publisher("/theatre/endoscope/is_recording", Bool, **latched)
        rospy.Service("/theatre/light", SetBool, self.switch)
        rospy.Service("/theatre/insufflator/raise", Trigger, lambda _: self.turn(STEP))
        rospy.Service("/theatre/insufflator/lower", Trigger, lambda _: self.turn(-STEP))
        rospy.Subscriber("/theatre/endoscope/record", Bool, self.recorder.publish)

    def switch(self, request: SetBoolRequest) -> SetBoolResponse:
        """Switch the light."""
        self.light.publish(request.data)
        return SetBoolResponse(True, "")

    def turn(self, step: float) -> TriggerResponse:
        """Change the pressure by a step [mmHg], within its limits."""
        pressure = self.pressure + step
        if not LOWEST <= pressure <= HIGHEST:
            words = f"{pressure:g} mmHg, allowed {LOWEST:g} to {HIGHEST:g}"
            return TriggerResponse(False, words)
        self.pressure = pressure
        self.gas.publish(pressure)
        return TriggerResponse(True, f"{pressure:g} mmHg")


if __name__ == "__main__":
    rospy.init_node("theatre_devices")
    Theatre()
    rospy.spin()
