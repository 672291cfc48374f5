# SPDX-License-Identifier: BSD-3-Clause
"""A robot whose reports a test makes by hand, and the alarms that stand and sound for it."""

from dataclasses import replace

from typed_config import load_file
from voice_assist.alarms.annunciator import Annunciator
from voice_assist.alarms.board import Board
from voice_assist.alarms.types import ControllerEvent, PartHealth, RobotState
from voice_assist.config.alarms import FILE, AlarmsConfig

CONFIG = load_file(AlarmsConfig, FILE)
STOPPED = "stopped by voice"
OVER = "tension 2.50 N, allowed 2.40 N"
LOST = "robot not connected"
OFF = "joint_4 0.060 rad off its set-point"
CODES = {STOPPED: "stop_topic", OVER: "over_tension", LOST: "not_connected", OFF: "off_setpoint"}


class Scene:
    """Reports of a controller and a voice node, made by hand; time goes on by `run`."""

    def __init__(self, **sound):
        self.board = Board(CONFIG.board)
        self.annunciator = Annunciator(replace(CONFIG.sound, **sound))
        self.now, self.robot = 0.0, RobotState(0.0, "active", is_active=True)
        self.heard = []  # of each sound the time, its name and whether it cut another off

    def be(self, **changes):
        if "halt_reason" in changes:
            changes["halt_reason_code"] = CODES.get(changes["halt_reason"], "")
        self.robot = replace(self.robot, **changes)
        return self.run(0.05)

    def event(self, kind, command="", message="", code=""):
        self.board.see_event(ControllerEvent(kind, command, message, code), self.now)
        return self.run(0.05)

    def health(self, name, message):
        self.board.see_health(PartHealth(name, bool(message), message), self.now)
        return self.run(0.05)

    def run(self, seconds, with_state=True):
        for _ in range(round(seconds / 0.05)):
            self.now += 0.05
            if with_state:
                self.board.see_state(replace(self.robot, stamp=self.now), self.now)
            self.board.tick(self.now)
            alarm = self.annunciator.next(self.board.standing, self.now)
            if alarm is not None:
                self.heard.append((round(self.now, 2), alarm.earcon))
        return self

    @property
    def first(self):
        return self.board.standing[0].alarm if self.board.standing else None

    def sounds(self):
        return [earcon for _, earcon in self.heard]
