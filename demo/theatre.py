# SPDX-License-Identifier: BSD-3-Clause
"""What acts beside the voice: a pedal, a hand on the command service, devices of the theatre."""

from __future__ import annotations

import shutil
import subprocess
import sys
import threading
from collections.abc import Callable
from pathlib import Path

import rospy
from sensor_msgs.msg import Joy

from demo.script import ScriptStep
from rst_control.srv import Command
from support.own_settings import copy_settings
from support.process_groups import start_group
from typed_config import load_file
from voice_assist.config import CONFIG_DIR
from voice_assist.config.pedal import PedalConfig

ROOT = Path(__file__).resolve().parent.parent
PRESSED = 0.2  # [s] that a foot stays on the pedal
BUTTONS = 8  # of the pedal that is played


def settings(folder: Path) -> dict[str, str | bool | Path]:
    """Launch arguments of a session with pedal and devices; its settings are written beside it."""
    config = copy_settings(folder / "config", "/demo_*")
    shutil.copy(config / "theatre_commands.yaml", config / "commands.yaml")
    return {"config": config, "pedal": True, "devices": True}


def start_devices() -> subprocess.Popen[bytes]:
    """Start the simulated light, insufflator and recorder."""
    return start_group([sys.executable, str(ROOT / "examples" / "theatre_devices.py")])


class Hands:
    """Presses the pedal, and calls the robot as a person at a terminal does.

    Args:
        complain: Shows what went wrong.
    """

    def __init__(self, complain: Callable[[str], None]) -> None:
        self._complain = complain
        pedal = load_file(PedalConfig, CONFIG_DIR / "pedal.yaml")
        self._buttons = {b.command: b.input for b in pedal.bindings if b.command}
        self._joy = rospy.Publisher(pedal.topic, Joy, queue_size=10)

    def act(self, step: ScriptStep) -> None:
        """Do a step that nobody says, in a thread of its own.

        Raises:
            RuntimeError: No pedal is bound to that command.
        """
        if step.speaker == "pedal" and step.say not in self._buttons:
            raise RuntimeError(f"no pedal for {step.say!r}, allowed: {', '.join(self._buttons)}")
        does = {"pedal": self._press, "hand": self._call}.get(step.speaker)
        if does is not None:
            threading.Thread(target=does, args=(step.say,), daemon=True).start()

    def _press(self, command: str) -> None:
        number = int(self._buttons[command].split()[1])
        for is_down in (False, True, False):  # released at first: only then a press counts
            buttons = [int(is_down and n == number) for n in range(BUTTONS)]
            message = Joy(buttons=buttons)
            message.header.stamp = rospy.Time.now()
            self._joy.publish(message)
            rospy.sleep(PRESSED)

    def _call(self, command: str) -> None:
        try:
            reply = rospy.ServiceProxy("rst_control/command", Command)(command)
        except rospy.ServiceException as error:
            self._complain(f"by hand: {error}")
            return
        if not reply.accepted:
            self._complain(f"by hand, refused: {reply.message}")
