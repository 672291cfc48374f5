# SPDX-License-Identifier: BSD-3-Clause
"""The pedal node: commands, talk gate and dead-man, from sensor_msgs/Joy or from a USB device.

Its stop is a supplementary stop as any other: it goes by this process and by the network, on the
topic of stops and by the controller's service.
"""

from __future__ import annotations

import argparse
import threading
import time
from collections.abc import Collection, Mapping

import rospy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from sensor_msgs.msg import Joy
from std_msgs.msg import Bool, Empty

from typed_config.ros.connections import is_heard, open_callers, open_listeners
from typed_config.ros.launch_settings import launch_settings
from typed_config.ros.registration import stay_registered
from typed_config.ros.starting import starting
from voice_assist.audio.capture.stamp_check import MAX_AHEAD
from voice_assist.config.pedal import PedalConfig, pedal_config
from voice_assist.intent.dialogue import Answered
from voice_assist.pedal.drivers import Drivers
from voice_assist.pedal.evdev import DEVICES, EvdevReader, EventsLostError, devices, find
from voice_assist.pedal.pedals import STOP, PedalAction, Pedals, Send
from voice_assist.ros.believed import Believed
from voice_assist.ros.robot.command_client import CommandClient
from voice_assist.ros.robot.robot_commands import require_pedal_commands

DEAD_MAN = "rst_control/dead_man"  # std_msgs/Bool, again and again: the controller asks for it
TALK = "voice_assist/talk"  # std_msgs/Bool, again and again while a pedal is the gate
PERIOD = 0.05  # [s] between checks of gate, dead-man and silence
DIAGNOSTICS_EVERY = 20  # checks
ANSWER_WITHIN = 1.0  # [s] for the controller; an older press commands nothing but a stop
NOT_FOUND = "not found yet"


class PedalNode:
    """Joins the device and the robot's controller; what follows from its news is under one lock.

    What is logged under it waits for no terminal: see typed_config/ros/terminal.py.

    Args:
        config: Device, and what each input does.

    Raises:
        ConfigError: `~believed` is not as it must be.
    """

    def __init__(self, config: PedalConfig) -> None:
        self._config, self._pedals, self._lock = config, Pedals(config), threading.Lock()
        self._trouble, self._late = NOT_FOUND, ""  # of the device, of its newest news
        self._drivers = Drivers(config, self._pedals, self._is_alive)
        self._news: dict[str, float] = {}  # [s] steady clock, by node; "": any message
        self._stop = rospy.Publisher("rst_control/stop", Empty, queue_size=10)
        self._talk = rospy.Publisher(TALK, Bool, queue_size=1)
        self._dead_man = rospy.Publisher(DEAD_MAN, Bool, queue_size=1, tcp_nodelay=True)
        self._diagnostics = rospy.Publisher("/diagnostics", DiagnosticArray, queue_size=2)
        self._client = CommandClient(ANSWER_WITHIN, self._on_answer)
        self._joy: rospy.Subscriber | None = None
        self._set_by: dict[str, str] = {}  # by input, node that set it last; "": any message
        self._known = Believed()

    def run(self) -> None:
        """Follow the device until ROS shuts down."""
        if self._config.source == "joy":
            topic = self._config.topic
            self._joy = self._known.hear("joy", topic, Joy, self._on_joy, queue_size=50)
        else:
            threading.Thread(target=self._read, name="pedal", daemon=True).start()
        rospy.on_shutdown(self._leave)
        checks = 0
        while not rospy.is_shutdown():
            self._check()
            if checks % DIAGNOSTICS_EVERY == 0:
                self._publish_diagnostics()
            checks += 1
            time.sleep(PERIOD)

    def _leave(self) -> None:
        with self._lock:
            self._carry_out(self._pedals.lost("the pedal node ends"))
            self._tell()

    def _on_joy(self, message: Joy) -> None:
        values = {f"button {i}": float(value) for i, value in enumerate(message.buttons)}
        values |= {f"axis {i}": float(value) for i, value in enumerate(message.axes)}
        header = getattr(message, "_connection_header", None) or {}
        driver = header.get("callerid", "")
        with self._lock:
            self._news |= dict.fromkeys(["", driver], time.monotonic())
            if not self._pedals.is_there:
                self._set_by.clear()
                self._found(f"joy on {self._config.topic}", values)
            values = self._drivers.counting(driver, values)
            self._set_by |= dict.fromkeys(["", *values], driver)
            self._take(values, message.header.stamp.to_sec())

    def _read(self) -> None:
        """Thread of a USB device: read it, look for it again when it is gone."""
        inputs = [binding.input for binding in self._config.bindings]
        while not rospy.is_shutdown():
            try:
                with EvdevReader(DEVICES / find(self._config.device), inputs) as reader:
                    there = reader.inputs()
                    with self._lock:
                        self._found(self._config.device, there)
                    for values in reader:
                        with self._lock:
                            self._take(values, reader.stamp)
            except EventsLostError as error:  # at once again: a press must not be missed meanwhile
                with self._lock:
                    self._lost(str(error), are_events_lost=True)
                continue
            except Exception as error:  # top of the thread: what is not read counts as released
                with self._lock:
                    self._lost(str(error) or repr(error))
            rospy.rostime.wallsleep(self._config.look_again)

    def _found(self, name: str, inputs: Collection[str]) -> None:
        self._pedals.found()
        self._pedals.check(inputs)
        self._trouble = ""
        rospy.loginfo("pedal: %s", name)
        self._say_remarks()

    def _lost(self, why: str, are_events_lost: bool = False) -> None:
        pedals = self._pedals
        self._carry_out(pedals.events_lost(why) if are_events_lost else pedals.lost(why))
        if why != self._trouble:
            rospy.logwarn("pedal: %s", why)
        self._trouble = why

    def _take(self, values: Mapping[str, float], stamp: float = 0.0) -> None:
        """Carry out what follows from news; its stamp is in seconds, 0: none."""
        late, was_held = _age_trouble(stamp), self._pedals.is_held
        actions = self._pedals.take(values, late)
        if self._pedals.is_held != was_held:
            self._tell()  # before a command of the same news
        self._carry_out(actions, late)
        if late and not self._late:
            rospy.logwarn("pedal: %s", late)
        self._late = late
        self._say_remarks()

    def _say_remarks(self) -> None:
        while self._pedals.remarks:
            rospy.logwarn("pedal: %s", self._pedals.remarks.pop(0))

    def _carry_out(self, actions: tuple[PedalAction, ...], why_not: str = "") -> None:
        """Act, then say so; with a reason why not, only what stops the robot."""
        for action in actions:
            if not isinstance(action, Send):
                self._send_stop()
                rospy.logwarn("pedal: %s; the robot is stopped", action.why)
                continue
            words = action.command, action.input
            if action.command == STOP:
                self._send_stop()
            elif why := why_not or self._deaf_controller() or action.why_not:
                rospy.logwarn("pedal: %s, by %s, is dropped: %s", *words, why)
                continue
            else:
                self._client.call(action.command, may_repeat=False)
            rospy.loginfo("pedal: %s, by %s", *words)

    def _send_stop(self) -> None:
        """By the topic, and by the service, which also reaches a controller of a new master."""
        self._client.forget()
        self._stop.publish(Empty())
        self._client.call(STOP, may_repeat=True)

    def _deaf_controller(self) -> str:
        """Why dead-man and gate are not known where the robot is moved; empty: they are, or none.

        The service of a controller may be there although it is not connected.
        """
        if not (self._pedals.has_dead_man or self._pedals.has_gate):
            return ""
        names = open_listeners(self._dead_man)
        if any(self._known.is_believed("controller", name) for name in names):
            return ""
        return f"the controller does not listen to {DEAD_MAN}"

    def _check(self) -> None:
        with self._lock:
            if why := self._silence():
                self._lost(why)
            self._tell()

    def _tell(self) -> None:
        """Say what is held down, to those who ask for it."""
        if self._pedals.has_gate:
            self._talk.publish(Bool(self._pedals.may_talk))
        if self._pedals.has_dead_man:
            self._dead_man.publish(Bool(self._pedals.is_held))

    def _on_answer(self, answered: Answered) -> None:
        log = rospy.loginfo if answered.is_accepted else rospy.logwarn
        log("pedal: %s: %s", answered.command, answered.message)

    def _silence(self) -> str:
        """Why a joy that was there is gone; empty: it is there, or it never was."""
        if self._joy is None or not self._pedals.is_there:
            return ""
        for name in sorted(set(self._set_by.values())):
            if not is_heard(self._joy, name):
                return f"{name} publishes {self._config.topic} no more"
        if self._age("") > self._config.silent_after > 0.0:
            return f"{self._config.topic} silent for {self._age(''):.1f} s"
        for name in sorted({by for key, by in self._set_by.items() if self._pedals.state(key)}):
            if not self._is_alive(name):  # another driver is no sign that this one's press lasts
                return f"{name} silent on {self._config.topic} for {self._age(name):.1f} s"
        return ""

    def _is_alive(self, driver: str) -> bool:
        """Whether a driver of the joy is connected, and not silent for too long."""
        if self._joy is None or not is_heard(self._joy, driver):
            return False
        allowed = self._config.silent_after
        return not allowed or self._age(driver) <= allowed

    def _age(self, driver: str) -> float:
        """Seconds since the last message of a driver; "": of any."""
        return time.monotonic() - self._news.get(driver, float("-inf"))

    def _state_of_device(self) -> tuple[int, str]:
        """Level of the pedal's diagnostics, and its words."""
        callers = open_callers(self._joy) if self._joy is not None else set()
        is_connected = any(self._known.is_believed("joy", name) for name in callers)
        is_quiet = self._trouble == NOT_FOUND and is_connected  # it sends changes only
        trouble = "" if is_quiet else self._trouble or self._late
        if trouble := trouble or self._deaf_controller():
            return DiagnosticStatus.ERROR, trouble
        return DiagnosticStatus.OK, "connected, nothing pressed yet" if is_quiet else "there"

    def _publish_diagnostics(self) -> None:
        with self._lock:
            level, words = self._state_of_device()
        status = DiagnosticStatus(level, f"{rospy.get_name()[1:]}: pedal", words, "", [])
        status.hardware_id = self._config.device or self._config.topic
        strangers = self._known.status("pedal", "pedal")
        message = DiagnosticArray(status=[status, strangers])
        message.header.stamp = rospy.Time.now()
        self._diagnostics.publish(message)


def _age_trouble(stamp: float) -> str:
    """Why news of a time [s] are too old to move the robot; empty: they are not, or have no age.

    Of a clock that is ahead the age is unknown, and a simulated one may be faster than a foot.
    """
    if not stamp or not rospy.rostime.is_wallclock():
        return ""
    age = rospy.get_time() - stamp
    if -MAX_AHEAD <= age <= ANSWER_WITHIN:
        return ""
    found = f"{age:.2f} s old" if age > 0.0 else f"{-age:.2f} s ahead of this host's clock"
    allowed = f"allowed: {ANSWER_WITHIN:g} s old, {MAX_AHEAD:g} s ahead"
    return f"its stamp is {found}, {allowed}; check the link, or run chrony"


def main() -> None:
    """Run the pedal node, or list the devices."""
    parser = argparse.ArgumentParser(prog="rosrun voice_assist pedal", description=__doc__)
    parser.add_argument("--list", action="store_true", help="show the names of all input devices")
    if parser.parse_args(rospy.myargv()[1:]).list:
        print("\n".join(sorted(set(devices().values()))) or "there is no input device")
        return
    with starting("pedal", __doc__, needs_clock=False):
        given = launch_settings()
        keys = PedalConfig.__dataclass_fields__
        config = pedal_config({key: given[key] for key in keys if key in given})
        require_pedal_commands(config)
        node = PedalNode(config)
    stay_registered()
    node.run()
