# SPDX-License-Identifier: BSD-3-Clause
"""Pictures of the scene without a screen: the robot, the trocar in the abdominal wall, the tissue.

They are drawn in a PyBullet world of their own, from a copied state.
"""

from __future__ import annotations

import math
import struct
import zlib
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pybullet
from numpy.typing import NDArray

from rst_control.config import CameraConfig, SceneConfig
from rst_control.simulation.physics import BulletWorld, joint_indices, load_robot
from rst_control.simulation.rendering.marks import SceneMarks
from rst_control.simulation.rendering.scene import SceneShapes
from rst_control.simulation.rendering.state import SceneState

SHARPNESS = 2  # each pixel is the mean of this many in each direction
LIGHT = (0.3, -0.8, 1.2)  # direction to the lamp, base frame
WINDOW_CLOSER = 0.75  # the window has a wider angle than the pictures
NEAR = 0.01  # [m] nothing closer is drawn

Image = NDArray[np.uint8]  # (height, width, 3)


class ScenePainter(BulletWorld):
    """Draws pictures in a world of its own; a context manager.

    Args:
        scene: Trocar and tissue.
        urdf: Model of the robot.
        window: Where a window shows it from, which needs a screen; None: no window.

    Raises:
        RuntimeError: There is no screen.
    """

    def __init__(self, scene: SceneConfig, urdf: Path, window: CameraConfig | None = None) -> None:
        super().__init__(pybullet.DIRECT if window is None else pybullet.GUI)
        if self._client < 0:
            raise RuntimeError("no window could be opened")
        self._robot = load_robot(urdf, self._client)
        self._joints = joint_indices(self._robot, self._client)
        self._shapes, self._marks = SceneShapes(scene, self._client), SceneMarks(self._client)
        if window is not None:
            self._view_from(window)

    def picture(self, state: SceneState, cameras: Sequence[CameraConfig]) -> Image:
        """Draw the scene as several cameras see it, side by side.

        Args:
            state: Joints and tissue.
            cameras: All of one height.
        """
        self.show(state)
        return np.hstack([self._shot(camera) for camera in cameras])

    def show(self, state: SceneState) -> None:
        """Put robot and tissue where they are; a window shows it at once."""
        on = {"physicsClientId": self._client}
        pybullet.configureDebugVisualizer(pybullet.COV_ENABLE_RENDERING, 0, **on)
        for joint, angle in zip(self._joints, state.joints, strict=True):
            pybullet.resetJointState(self._robot, joint, float(angle), **on)
        self._shapes.show_tissue(state.nodes)
        self._marks.show(state.trail, state.tip, state.force)
        pybullet.configureDebugVisualizer(pybullet.COV_ENABLE_RENDERING, 1, **on)

    def _view_from(self, camera: CameraConfig) -> None:
        on = {"physicsClientId": self._client}
        pybullet.configureDebugVisualizer(pybullet.COV_ENABLE_GUI, 0, **on)
        pybullet.configureDebugVisualizer(pybullet.COV_ENABLE_SHADOWS, 0, **on)
        pybullet.resetDebugVisualizerCamera(
            WINDOW_CLOSER * camera.distance,
            math.degrees(camera.yaw),
            math.degrees(camera.pitch),
            camera.target,
            **on,
        )
        colours = {  # a window shows one colour a link, its last: let it be that of its first shape
            shape[1]: shape[7] for shape in reversed(pybullet.getVisualShapeData(self._robot, **on))
        }
        for link, colour in colours.items():
            pybullet.changeVisualShape(self._robot, link, rgbaColor=colour, **on)

    def _shot(self, camera: CameraConfig) -> Image:
        width, height = (SHARPNESS * n for n in camera.size)
        view = pybullet.computeViewMatrixFromYawPitchRoll(
            camera.target,
            camera.distance,
            math.degrees(camera.yaw),
            math.degrees(camera.pitch),
            0.0,
            2,
        )
        projection = pybullet.computeProjectionMatrixFOV(
            math.degrees(camera.field_of_view), width / height, NEAR, camera.reach
        )
        _, _, pixels, depth, _ = pybullet.getCameraImage(
            width,
            height,
            view,
            projection,
            lightDirection=LIGHT,
            shadow=0,
            lightAmbientCoeff=0.55,
            lightDiffuseCoeff=0.5,
            lightSpecularCoeff=0.12,
            renderer=pybullet.ER_TINY_RENDERER,
            flags=pybullet.ER_NO_SEGMENTATION_MASK,
            physicsClientId=self._client,
        )
        colours = np.array(pixels, dtype=np.uint8).reshape(height, width, 4)[:, :, :3]
        empty = np.asarray(depth).reshape(height, width) >= 1.0
        fade = np.linspace(0.0, 1.0, height)[:, None, None]
        sky = (1.0 - fade) * np.array(camera.sky_top) + fade * np.array(camera.sky_bottom)
        colours[empty] = (255.0 * np.broadcast_to(sky, colours.shape)[empty]).astype(np.uint8)
        blocks = colours.reshape(camera.size[1], SHARPNESS, camera.size[0], SHARPNESS, 3)
        image: Image = blocks.mean(axis=(1, 3)).astype(np.uint8)
        return image


def png_bytes(image: Image) -> bytes:
    """Encode a picture as PNG."""
    height, width, _ = image.shape
    rows = np.hstack([np.zeros((height, 1), np.uint8), image.reshape(height, 3 * width)])
    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    return b"".join(
        [
            b"\x89PNG\r\n\x1a\n",
            _chunk(b"IHDR", header),
            _chunk(b"IDAT", zlib.compress(rows.tobytes(), 6)),
            _chunk(b"IEND", b""),
        ]
    )


def _chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
