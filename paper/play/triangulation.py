# SPDX-License-Identifier: BSD-3-Clause
"""The triangulation demonstration: the whole sequence of commands once, with pictures."""

from __future__ import annotations

import time
from pathlib import Path

from rich.console import Console

from demo.film import take_picture
from paper.config import ExperimentConfig, PaperVoiceConfig
from paper.play.demonstration import InOrder
from paper.play.session import play
from paper.play.speaker import Speaker

NAME = "triangulation"  # of its folder
TISSUE_PERIOD = 1.2  # [s] in which the simulator says once how the tissue is held


def run(voice: PaperVoiceConfig, config: ExperimentConfig, folder: Path, console: Console) -> None:
    """Play the demonstration in one voice, with a picture of the tissue after each command.

    Raises:
        RuntimeError: The system or the voice failed.
        OSError: There is no virtual microphone.
    """
    speaker = Speaker(voice, config, config.seed + 1)

    def picture() -> None:
        taken = take_picture(lambda words: console.print(f"  {words}", style="yellow"))
        time.sleep(TISSUE_PERIOD)
        taken.join()

    play(InOrder(), speaker, config, folder, console, picture)
