# SPDX-License-Identifier: BSD-3-Clause
"""An install space, built from a copy of the sources that is then removed."""

import os
import shutil
import signal
import subprocess
from pathlib import Path

from tests.__main__ import give_way

ROOT = Path(__file__).resolve().parents[2]
FOLDERS = ("catkin_ws", "docker")
BUILT = ("build", "devel", "install", "*.pyc", "*.pyc.*", "*.tmp.*", ".catkin_workspace")
BROKEN = "raise ImportError('this em lies under ~/.local')\n"


class InstallSpace:
    """It is built in the background, at a low priority.

    Attributes:
        home: A home folder whose ~/.local has a broken package of the messages' generators.
        environment: Of a fresh login there.
        prefix: The space; `finish` waits for it.
    """

    def __init__(self, folder):
        self.home, self.prefix = folder / "home", folder / "prefix" / "space"
        self._copy, self._printed = folder / "copy", folder / "printed.txt"
        site = self.home / ".local" / "lib" / "python3.11" / "site-packages"
        site.mkdir(parents=True)
        (site / "em.py").write_text(BROKEN, encoding="utf-8")
        self.environment = {
            "HOME": str(self.home),
            "PATH": "/usr/bin:/bin",
            "LANG": "C.UTF-8",
            "ROS_IP": "127.0.0.1",
            "ROS_LANG_DISABLE": "gencpp:genlisp",  # half of the build; nothing here uses it
        }
        for name in FOLDERS:
            leave_out = shutil.ignore_patterns(*BUILT)
            shutil.copytree(ROOT / name, self._copy / name, symlinks=True, ignore=leave_out)
        shutil.copy(ROOT / "LICENSE", self._copy)
        (self._copy / ".venv").symlink_to((ROOT / ".venv").resolve())
        with self._printed.open("wb") as file:
            self._build = subprocess.Popen(
                [str(self._copy / "docker" / "setup.sh"), "install", str(self.prefix)],
                env=self.environment,
                stdin=subprocess.DEVNULL,
                stdout=file,
                stderr=subprocess.STDOUT,
                preexec_fn=give_way,
            )

    def finish(self):
        """Wait for the space, and remove the copy of its sources."""
        status = self._build.wait()
        printed = self._printed.read_text(encoding="utf-8", errors="replace")
        assert status == 0, printed[-8000:]
        shutil.rmtree(self._copy)

    def close(self):
        """End what is left of the build."""
        if self._build.poll() is None:
            os.killpg(self._build.pid, signal.SIGKILL)
            self._build.wait()
