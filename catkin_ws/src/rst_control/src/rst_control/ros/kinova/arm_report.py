# SPDX-License-Identifier: BSD-3-Clause
"""The arm's own state and facts by ROS: messages of Kinova's driver read and written."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Any, Final

import genpy
import numpy as np
import rospy
from kortex_driver.msg import (
    ActuatorFeedback,
    BaseCyclic_Feedback,
    ControlConfig_ControlModeInformation,
    KinematicLimits,
)
from kortex_driver.msg import Empty as NoInput
from kortex_driver.srv import GetFirmwareBundleVersions, GetKinematicSoftLimits

from rst_control.kinova.arm_state import (
    FIRMWARE_SERVICE,
    LIMITS_SERVICE,
    SPEEDS_MODE,
    ArmReport,
    Banks,
    SoftLimits,
    named,
)

ASK_AGAIN: Final = 1.0  # [s] between two looks whether something has to be asked
SAY_AGAIN: Final = 10.0  # [s] before the same complaint is made again
LOST_CONNECTION = (rospy.exceptions.ROSInternalException, OSError)  # in the midst of a call
FIRMWARE_TRIES: Final = 5  # a driver may not know it
ANSWER_TIME: Final = 2.0  # [s] for a service to be there


def read_report(message: BaseCyclic_Feedback, arrived: float) -> ArmReport:
    """The state in one message that arrived at a time [s], steady clock."""
    base, wrist, joints = message.base, message.interconnect, message.actuators
    warnings = named(
        Banks(base.warning_bank_a, base.warning_bank_b),
        tuple(Banks(joint.warning_bank_a, joint.warning_bank_b) for joint in joints),
        Banks(wrist.warning_bank_a, wrist.warning_bank_b),
    )
    return ArmReport(
        state=base.active_state,
        connection=base.active_state_connection_identifier,
        stamp=arrived,
        base=Banks(base.fault_bank_a, base.fault_bank_b),
        joints=tuple(Banks(joint.fault_bank_a, joint.fault_bank_b) for joint in joints),
        wrist=Banks(wrist.fault_bank_a, wrist.fault_bank_b),
        warnings=tuple(warnings),
    )


def written_report(report: ArmReport, count: int) -> BaseCyclic_Feedback:
    """The message of a state, the reverse of `read_report` without warnings."""
    message = BaseCyclic_Feedback(frame_id=count % 2**32)
    message.base.active_state = report.state
    message.base.active_state_connection_identifier = report.connection
    message.base.fault_bank_a, message.base.fault_bank_b = report.base.a, report.base.b
    message.interconnect.fault_bank_a = report.wrist.a
    message.interconnect.fault_bank_b = report.wrist.b
    message.actuators = [
        ActuatorFeedback(fault_bank_a=banks.a, fault_bank_b=banks.b) for banks in report.joints
    ]
    return message


def ask_limits(namespace: str) -> SoftLimits:
    """Ask the arm for the soft limits that it keeps when joint speeds lead it.

    Raises:
        rospy.ServiceException: The driver refused.
        rospy.ROSException: There is no such service.
    """
    mode = ControlConfig_ControlModeInformation(SPEEDS_MODE)
    limits = _asked(f"{namespace}/{LIMITS_SERVICE}", GetKinematicSoftLimits, mode)
    return SoftLimits(
        np.radians(limits.joint_speed_limits), np.radians(limits.joint_acceleration_limits)
    )


def written_limits(limits: SoftLimits) -> KinematicLimits:
    """The message of soft limits, in degrees as the arm counts."""
    speed, acceleration = (np.degrees(row).tolist() for row in (limits.speed, limits.acceleration))
    return KinematicLimits(SPEEDS_MODE, 0.0, 0.0, speed, acceleration)


def ask_firmware(namespace: str) -> str:
    """Ask the arm for the version of its firmware.

    Raises:
        rospy.ServiceException: The driver refused.
        rospy.ROSException: There is no such service.
    """
    versions = _asked(f"{namespace}/{FIRMWARE_SERVICE}", GetFirmwareBundleVersions, NoInput())
    return str(versions.main_bundle_version)


def _asked(name: str, kind: type, given: genpy.Message) -> Any:
    """The output of one of the driver's services."""
    rospy.wait_for_service(name, ANSWER_TIME)
    return rospy.ServiceProxy(name, kind)(given).output


class ArmFacts:
    """Asks for limits while they are wanted, and a few times for the firmware, in its own thread.

    Args:
        namespace: Of the driver.
        is_wanted: The limits are not known.
        on_limits: Takes them.
    """

    def __init__(
        self, namespace: str, is_wanted: Callable[[], bool], on_limits: Callable[[SoftLimits], None]
    ) -> None:
        self._namespace, self._is_wanted, self._on_limits = namespace, is_wanted, on_limits
        self.firmware = ""
        threading.Thread(target=self._ask, name="arm facts", daemon=True).start()

    def _ask(self) -> None:
        tries = 0
        while not rospy.is_shutdown():
            if self._is_wanted():
                self._try(lambda: self._on_limits(ask_limits(self._namespace)))
                if not self._is_wanted():
                    tries = 0  # the driver is there now
            if not self.firmware and (tries := tries + 1) <= FIRMWARE_TRIES:
                self._try(lambda: setattr(self, "firmware", ask_firmware(self._namespace)))
            time.sleep(ASK_AGAIN)

    def _try(self, ask: Callable[[], None]) -> None:
        try:
            ask()
        except (rospy.ServiceException, rospy.ROSException, *LOST_CONNECTION) as error:
            rospy.logwarn_throttle(SAY_AGAIN, f"the arm does not answer: {error}")
