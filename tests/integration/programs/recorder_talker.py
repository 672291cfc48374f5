# SPDX-License-Identifier: BSD-3-Clause
"""The process that talks to the recorder under test: `recorder_talker.py traffic 1500`."""

import json
import sys
import time
from functools import cache

from support.waiting import wait_until

FAST = ("/joint_states", "/robot/servo_jp", "/robot/tension")
ARRIVED = 1.5  # [s] after which what was sent had arrived
ODD = """
uint8 LIMIT=5
strange_msgs/Part[] parts
time when
duration lasting
int16[3] fixed
string[] words
uint8[] raw
bool is_true
uint64 large
""".strip()
PART = "string name\nfloat32[] samples"


@cache
def odd_classes():
    """Classes of types that no package of this machine defines."""
    from genpy.dynamic import generate_dynamic

    definition = f"{ODD}\n{'=' * 80}\nMSG: strange_msgs/Part\n{PART}\n"
    return generate_dynamic("strange_msgs/Odd", definition)


def odd_message():
    """Nested messages, arrays fixed and variable, empty ones, time and duration."""
    import genpy

    part, odd = odd_classes()["strange_msgs/Part"], odd_classes()["strange_msgs/Odd"]()
    odd.parts = [part("a", [1.5]), part("", []), part("ü", [2.0, 3.0])]
    odd.when, odd.lasting = genpy.Time(7, 8), genpy.Duration(-9, 10)
    odd.fixed, odd.words, odd.raw = [-1, 2, 3], ["", "x y"], b"\0\xff"
    odd.is_true, odd.large = True, 2**63 + 1
    return odd


def say(**values):
    sys.stdout.write(json.dumps(values) + "\n")  # at once: threads write side by side
    sys.stdout.flush()


class Talker:
    """Publishes what the system would."""

    def __init__(self):
        import rospy
        from geometry_msgs.msg import WrenchStamped
        from sensor_msgs.msg import JointState

        names = [f"joint_{i}" for i in range(1, 8)]
        self.joints = JointState(name=names, position=[0.0] * 7, velocity=[0.0] * 7)
        self.wrench = WrenchStamped()
        kinds = (JointState, JointState, WrenchStamped)
        pairs = zip(FAST, kinds, strict=True)
        self.out = [rospy.Publisher(t, kind, queue_size=2000) for t, kind in pairs]
        self.count = 0
        while not all(p.get_num_connections() for p in self.out) and not rospy.is_shutdown():
            rospy.sleep(0.05)

    def publish(self):
        self.joints.position[0] = float(self.count)
        for publisher, message in zip(
            self.out, (self.joints, self.joints, self.wrench), strict=True
        ):
            publisher.publish(message)
        self.count += 1


def traffic(count):
    import rospy
    from std_msgs.msg import Empty, String, Time

    written = []
    rospy.Subscriber("/session_log/written", Time, written.append)
    latched = rospy.Publisher("/latched", String, latch=True, queue_size=1)
    latched.publish("said once, long ago")
    odd = rospy.Publisher("/odd", odd_classes()["strange_msgs/Odd"], latch=True, queue_size=1)
    odd.publish(odd_message())
    talker = Talker()
    rate = rospy.Rate(500)
    late = None
    for k in range(count):
        talker.publish()
        if k == count // 2:
            late = rospy.Publisher("/late", Empty, latch=True, queue_size=1)
            late.publish()
        rate.sleep()
    wait_until(lambda: odd.get_num_connections() and late.get_num_connections(), "the recorder")
    end = time.time() + ARRIVED
    while not written or written[-1].data.to_sec() < end:
        rospy.sleep(0.05)
    say(published=talker.count, late=late is not None)


def until_killed():
    import rospy
    from std_msgs.msg import Time

    stamps = []

    def acknowledge(message):
        # the stamp is taken before the message leaves, so what left two seconds before the
        # acknowledged time had arrived by then
        until = message.data.to_sec() - 2.0
        say(acknowledged=sum(stamp < until for stamp in list(stamps)))

    rospy.Subscriber("/session_log/written", Time, acknowledge)
    talker = Talker()
    rate = rospy.Rate(500)
    while not rospy.is_shutdown():
        stamps.append(time.time())
        talker.publish()
        rate.sleep()


def watch():
    import rospy
    from diagnostic_msgs.msg import DiagnosticArray
    from std_msgs.msg import String

    file, heartbeat = [""], ["none yet"]
    rospy.Subscriber("/session_log/file", String, lambda m: file.__setitem__(0, m.data))

    def hear(message):
        if message.data != heartbeat[0]:
            heartbeat[0] = message.data
            say(level=None, message="", file=file[0], heartbeat=message.data)

    rospy.sleep(1.0)

    def show(array):
        for status in array.status:
            if status.name == "recorder: recording":
                level = status.level[0] if isinstance(status.level, bytes) else status.level
                say(level=level, message=status.message, file=file[0], heartbeat=heartbeat[0])

    rospy.Subscriber("/session_log/recording", String, hear)
    rospy.sleep(1.0)
    rospy.Subscriber("/diagnostics", DiagnosticArray, show)
    rospy.spin()


def listen(prefix):
    """Hear a recording that is played, by ROS's own classes, until the joint states end."""
    import rospy
    from sensor_msgs.msg import JointState

    joints, odd = [], []
    rospy.Subscriber(f"{prefix}/joint_states", JointState, joints.append)
    rospy.Subscriber(f"{prefix}/odd", odd_classes()["strange_msgs/Odd"], odd.append)
    say(ready=True)
    while not joints or joints[-1].position[0] < 1499.0:
        rospy.sleep(0.05)
    say(
        joints=[m.position[0] for m in joints],
        name=joints[0].name[6],
        odd=odd == [odd_message()],
        urdf=rospy.get_param(f"{prefix}/robot_description"),
    )


def main(words):
    import rospy

    rospy.init_node("talker", anonymous=True)
    if words[0] == "traffic":
        traffic(int(words[1]))
    elif words[0] == "listen":
        listen(words[1])
    elif words[0] == "until_killed":
        until_killed()
    else:
        watch()


if __name__ == "__main__":
    main(sys.argv[1:])
