# SPDX-License-Identifier: BSD-3-Clause
"""A private PulseAudio server whose null sink is a microphone: what is played can be recorded."""

from __future__ import annotations

import os
import shutil
import subprocess
import tempfile
import time
from pathlib import Path

from support.process_groups import start_group
from typed_config.priority import weigh_session

START_TIME = 8.0  # [s] allowed for the server to answer
NICE = -20  # of server and player, where root runs them: a surgeon's voice waits for no processor


class VirtualMicrophone:
    """Context manager around one PulseAudio server; nothing outside it is touched."""

    def __init__(
        self, sink: str = "surgeon", rate: int = 48_000, start_time: float = START_TIME
    ) -> None:
        self._sink, self._rate, self._start_time = sink, rate, start_time
        self._folder = Path()
        self._server: subprocess.Popen[bytes] | None = None

    @property
    def device(self) -> str:
        """Its name for the voice node."""
        return f"pulse:{self._sink}.monitor"

    @property
    def environment(self) -> dict[str, str]:
        """Variables that point a program at this server."""
        return {
            "PULSE_SERVER": f"unix:{self._folder / 'native'}",
            "PULSE_RUNTIME_PATH": str(self._folder),
            "PULSE_COOKIE": str(self._folder / "cookie"),
        }

    def __enter__(self) -> VirtualMicrophone:
        if shutil.which("pulseaudio") is None:
            raise OSError("pulseaudio is not installed")
        self._folder = Path(tempfile.mkdtemp(prefix="virtual_microphone_"))
        modules = [
            f"module-native-protocol-unix socket={self._folder / 'native'} auth-anonymous=1",
            f"module-null-sink sink_name={self._sink} rate={self._rate} channels=1",
        ]
        command = ["pulseaudio", "-n", "--daemonize=no", "--exit-idle-time=-1", "--use-pid-file=no"]
        command += ["--disable-shm=yes", *(f"--load={module}" for module in modules)]
        env = {**os.environ, **self.environment, "HOME": str(self._folder)}
        env.pop("PULSE_SERVER")
        self._server = start_group(
            command, env=env, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
        weigh_session(NICE, self._server.pid)
        try:
            self._wait_until_it_answers()
        except BaseException:  # Ctrl-C too
            self._close()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        self._close()

    def play(self, wav: Path, ahead_ms: int = 200) -> subprocess.Popen[bytes]:
        """Begin to play a sound file into the microphone; returns the player.

        Args:
            wav: The sound.
            ahead_ms: Sound that the server holds ready [ms]; too little for a busy machine, and
                there are gaps in it.
        """
        player = subprocess.Popen(
            ["paplay", f"--latency-msec={ahead_ms}", f"--device={self._sink}", str(wav)],
            env={**os.environ, **self.environment},
            start_new_session=True,
        )
        weigh_session(NICE, player.pid)
        return player

    def _wait_until_it_answers(self) -> None:
        deadline = time.monotonic() + self._start_time
        while time.monotonic() < deadline:
            if self._server is None or self._server.poll() is not None:
                raise OSError("pulseaudio ended at once")
            if self._answers():
                return
            time.sleep(0.1)
        raise OSError(f"pulseaudio did not answer within {self._start_time:g} s")

    def _answers(self) -> bool:
        probe = subprocess.run(
            ["pactl", "list", "short", "sinks"],
            env={**os.environ, **self.environment},
            capture_output=True,
            check=False,
        )
        return probe.returncode == 0 and self._sink.encode() in probe.stdout

    def _close(self) -> None:
        if self._server is not None:
            self._server.terminate()
            try:
                self._server.wait(5.0)
            except subprocess.TimeoutExpired:
                self._server.kill()
                self._server.wait()
        shutil.rmtree(self._folder, ignore_errors=True)
