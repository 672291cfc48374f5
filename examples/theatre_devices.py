#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Simulated devices that `config/devices.yaml` calls: light, insufflator, endoscope's recorder."""

import rospy
from std_msgs.msg import Bool, Float64
from std_srvs.srv import SetBool, SetBoolRequest, SetBoolResponse, Trigger, TriggerResponse

STEP, REST, LOWEST, HIGHEST = 1.0, 12.0, 8.0, 15.0  # [mmHg]


class Theatre:
    """All three."""

    def __init__(self) -> None:
        self.level, kept = REST, {"queue_size": 1, "latch": True}
        self.light = rospy.Publisher("/theatre/light/state", Bool, **kept)
        self.gas = rospy.Publisher("/theatre/insufflator/pressure", Float64, **kept)
        recorder = rospy.Publisher("/theatre/endoscope/is_recording", Bool, **kept)
        rospy.Service("/theatre/light", SetBool, self._switch)
        rospy.Service("/theatre/insufflator/raise", Trigger, lambda _: self._set(self.level + STEP))
        # A stop undoes any number of steps by one call, so it leads to one pressure.
        rospy.Service("/theatre/insufflator/lower", Trigger, lambda _: self._set(REST))
        rospy.Subscriber("/theatre/endoscope/record", Bool, recorder.publish)

    def _switch(self, request: SetBoolRequest) -> SetBoolResponse:
        self.light.publish(request.data)
        return SetBoolResponse(True, "")

    def _set(self, wanted: float) -> TriggerResponse:
        if is_allowed := LOWEST <= wanted <= HIGHEST:
            self.level = wanted
            self.gas.publish(wanted)
        return TriggerResponse(is_allowed, f"{wanted:g} mmHg, allowed {LOWEST:g} to {HIGHEST:g}")


if __name__ == "__main__":
    rospy.init_node("theatre_devices")
    theatre = Theatre()
    rospy.spin()
