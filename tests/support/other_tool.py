# SPDX-License-Identifier: BSD-3-Clause
"""A description of the robot whose tool is bolted on elsewhere."""

import re

from rst_control.config import URDF_FILE

_MOUNT = r'(<joint name="joint_interface" type="fixed">\s*<origin xyz=")[^"]+'


def tool_beside(offset: float) -> str:
    """URDF text with the shaft beside the flange's middle, along its x [m]."""
    text, count = re.subn(_MOUNT, rf"\g<1>{offset} 0 0.1335", URDF_FILE.read_text("utf-8"))
    assert count == 1
    return text
