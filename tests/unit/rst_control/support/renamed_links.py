# SPDX-License-Identifier: BSD-3-Clause
"""The shipped robot with other names for the links that no page asks for, and its shapes so."""

from dataclasses import replace

from rst_control.config import URDF_FILE

NAMES = {
    "shoulder_link": "turret",
    "pitch_link": "clevis",
    "finger_left_link": "jaw",
    "finger_right_link": "other_jaw",
}


def renamed_urdf():
    """Text of the shipped URDF with those names."""
    text = URDF_FILE.read_text(encoding="utf-8")
    for old, new in NAMES.items():
        assert f'"{old}"' in text
        text = text.replace(f'"{old}"', f'"{new}"')
    return text


def renamed_shapes(config):
    """A CollisionConfig with those names."""
    bodies = tuple(replace(body, link=_new(body.link)) for body in config.bodies)
    left_out = tuple(
        replace(entry, link=_new(entry.link), others=tuple(map(_new, entry.others)))
        for entry in config.left_out
    )
    return replace(config, bodies=bodies, left_out=left_out)


def _new(name):
    return NAMES.get(name, name)
