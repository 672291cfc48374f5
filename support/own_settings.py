# SPDX-License-Identifier: BSD-3-Clause
"""A session's own copy of the settings, in which a program plays the joystick of the pedals."""

from __future__ import annotations

import shutil
from pathlib import Path

import yaml

from typed_config import load_yaml
from voice_assist.config import CONFIG_DIR

BELIEVED = "believed.yaml"


def copy_settings(folder: Path, joystick: str) -> Path:
    """Copy the package's settings; the pedals believe no other joystick.

    Args:
        folder: Gets the files.
        joystick: Name of the node that presses, where a * may stand at the end.

    Returns:
        The folder.
    """
    shutil.copytree(CONFIG_DIR, folder, dirs_exist_ok=True)
    believed = {**load_yaml(CONFIG_DIR / BELIEVED), "joy": [joystick]}
    (folder / BELIEVED).write_text(yaml.safe_dump(believed), encoding="utf-8")
    return folder
