# SPDX-License-Identifier: BSD-3-Clause
"""A master and launches beside it, as on a machine of its own; each can be killed alone."""

import os
import subprocess
from pathlib import Path

import rosgraph
import yaml

from support.launched_system import free_port
from support.process_groups import end_group
from support.waiting import PATIENCE, wait_until

ROOT = Path(__file__).resolve().parents[2]
ROSTEST = ROOT / "tests" / "rostest"
ASK = 0.1  # [s] between two questions to the master, each of which is work for both
CORE = {"/rosout"}  # node of the master's own


def patient_controller(folder, own_speeds=(), **sections):
    """File with the settings of patient_controller.yaml, but the product's own speeds.

    Args:
        folder: Where it is written.
        own_speeds: Which; none named: all.
        **sections: More sections of the controller.
    """
    settings = yaml.safe_load((ROSTEST / "patient_controller.yaml").read_text(encoding="utf-8"))
    controller = settings["controller"]
    speeds = controller.pop("speed")
    if own_speeds:
        sections["speed"] = {name: v for name, v in speeds.items() if name not in own_speeds}
    controller |= sections
    file = folder / "controller.yaml"
    file.write_text(yaml.safe_dump(settings), encoding="utf-8")
    return file


class Host:
    """A master and launches, each in a process group of its own.

    Attributes:
        environment: Of what is started here, and of who wants to find it.
        master: The master's API.
    """

    def __init__(self, folder):
        self.port = free_port()
        uri = f"http://127.0.0.1:{self.port}"
        self.environment = {
            **os.environ,
            "ROS_IP": "127.0.0.1",
            "ROS_MASTER_URI": uri,
            "ROS_HOME": str(folder / "ros"),
            "ROS_LOG_DIR": str(folder / "logs"),
            "PYTHONUNBUFFERED": "1",  # tests read what is printed meanwhile
        }
        self._output = folder / "said.txt"
        self._log = self._output.open("ab")
        self._running = []
        self.master = rosgraph.Master("/test", uri)

    def start(self, *words, beside=None, **streams):
        """Begin a process; `beside` holds variables for its environment alone.

        What it prints goes to the log, unless `streams` says otherwise, as Popen takes it.
        """
        process = subprocess.Popen(
            words,
            start_new_session=True,
            env={**self.environment, **(beside or {})},
            **{"stdout": self._log, "stderr": subprocess.STDOUT, **streams},
        )
        self._running.append(process)
        return process

    def start_master(self):
        process = self.start("roscore", "-p", str(self.port))
        wait_until(lambda: self.parameter("/run_id"), "a master", every=ASK)  # which launches read
        return process

    def launch(self, name, beside=None, **arguments):
        """Begin a launch file; one that is the only one needs no master before it."""
        words = [f"{key}:={value}" for key, value in arguments.items()]
        file = str(ROOT / "launch" / f"{name}.launch")
        return self.start("roslaunch", file, *words, beside=beside)

    def said(self):
        """All that was printed by what was started here."""
        return self._output.read_text(encoding="utf-8", errors="replace")

    def is_there(self):
        return bool(self._asked(self.master.getPid))

    def is_found(self, service):
        return bool(self._asked(self.master.lookupService, service))

    def hears(self, node, *topics):
        """Whether a node has subscribed to all these topics."""
        state = self._asked(self.master.getSystemState) or ((), (), ())
        subscribers = dict(state[1])
        return all(node in subscribers.get(topic, ()) for topic in topics)

    def wait_for_nodes(self):
        """Wait until the first node of a launch is there; all parameters are set by then."""
        wait_until(lambda: self.nodes() - CORE, "the first node", 2 * PATIENCE, every=ASK)

    def give(self, command, namespace=""):
        """What `rosservice call` prints of a command, as a client that begins anew."""
        service = f"{namespace}/rst_control/command"
        done = subprocess.run(
            ["rosservice", "call", service, f"command: '{command}'"],
            env=self.environment,
            capture_output=True,
            text=True,
            timeout=PATIENCE,
            check=False,
        )
        return done.stdout + done.stderr

    def parameter(self, name):
        """A parameter by its full name; None where it, or the master, is not there."""
        return self._asked(self.master.getParam, name)

    def nodes(self):
        """Names of the nodes that the master knows."""
        state = self._asked(self.master.getSystemState) or ()
        return {node for part in state for _, nodes in part for node in nodes}

    def _asked(self, question, *words):
        try:
            return question(*words)
        except (OSError, rosgraph.MasterException):
            return None

    def close(self):
        """End all that was started here, the newest first."""
        for process in reversed(self._running):
            end_group(process)  # as long as roslaunch may need for its nodes
        self._log.close()
