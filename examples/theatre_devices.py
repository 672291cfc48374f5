#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Simulated devices that `config/devices.yaml` calls: light, insufflator, endoscope's recorder."""

from __future__ import annotations

import rospy
from std_msgs.msg import Bool, Float64
from std_srvs.srv import SetBool, SetBoolRequest, SetBoolResponse, Trigger, TriggerResponse

STEP, LOWEST, HIGHEST = 1.0, 8.0, 15.0  # [mmHg]


class Theatre:
    def __init__(self) -> None:
        self.pressure = 12.0
        latched = {"queue_size": 1, "latch": True}
        self.light = rospy.Publisher("/theatre/light/state", Bool, **latched)
        self.gas = rospy.Publisher("/theatre/insufflator/pressure", Float64, **latched)
        recorder = rospy.Publisher("/theatre/endoscope/is_recording", Bool, **latched)
        rospy.Service("/theatre/light", SetBool, self.switch)
        rospy.Service("/theatre/insufflator/raise", Trigger, lambda _: self.turn(STEP))
        rospy.Service("/theatre/insufflator/lower", Trigger, lambda _: self.turn(-STEP))
        rospy.Subscriber("/theatre/endoscope/record", Bool, recorder.publish)

    def switch(self, request: SetBoolRequest) -> SetBoolResponse:
        self.light.publish(request.data)
        return SetBoolResponse(True, "")

    def turn(self, step: float) -> TriggerResponse:
        if not LOWEST <= (pressure := self.pressure + step) <= HIGHEST:
            return TriggerResponse(False, f"{pressure:g} mmHg, allowed {LOWEST:g} to {HIGHEST:g}")
        self.pressure = pressure
        self.gas.publish(pressure)
        return TriggerResponse(True, f"{pressure:g} mmHg")


if __name__ == "__main__":
    rospy.init_node("theatre_devices")
    theatre = Theatre()
    rospy.spin()
