# SPDX-License-Identifier: BSD-3-Clause
"""Pictures of the scene: what moves shows, and the drawing process answers or says why not."""

import io
import signal
from dataclasses import replace

import matplotlib.image
import numpy as np
import pytest

from rst_control.config import URDF_FILE, load_simulation_config
from rst_control.kinematics.configuration import robot_joints
from rst_control.simulation.rendering import window
from rst_control.simulation.rendering.painter import ScenePainter, png_bytes
from rst_control.simulation.rendering.state import SceneSetup, SceneState
from rst_control.simulation.rendering.worker import SceneLostError, SceneWorker
from rst_control.tissue.sheet import rest_points

CONFIG = load_simulation_config()
REST = rest_points(CONFIG.scene.tissue)
HOME = robot_joints(np.array(CONFIG.scene.home), 0.3)
CAMERAS = tuple(
    replace(camera, size=(160, 120))
    for camera in (CONFIG.simulator.overview, CONFIG.simulator.endoscope)
)


def test_robot_and_tissue_show_where_they_are():
    with ScenePainter(CONFIG.scene, URDF_FILE) as painter:
        home = painter.picture(SceneState(HOME, REST), CAMERAS)
        again = painter.picture(SceneState(HOME, REST), CAMERAS)
        moved = painter.picture(SceneState(HOME + 0.2, REST), CAMERAS)
        pulled = painter.picture(SceneState(HOME, REST + REST[:, 2:] * [0, 0, 0.1]), CAMERAS)
    assert home.shape == (120, 320, 3)
    assert np.array_equal(home, again)
    left, right = (slice(None), slice(160)), (slice(None), slice(160, None))
    assert (home[left] != moved[left]).any(axis=2).mean() > 0.02
    assert (home[right] != pulled[right]).any(axis=2).mean() > 0.05


def test_png_keeps_every_pixel():
    image = np.random.default_rng(1).integers(0, 256, (7, 5, 3), dtype=np.uint8)
    read = matplotlib.image.imread(io.BytesIO(png_bytes(image)))
    assert np.array_equal((read[:, :, :3] * 255.0).round().astype(np.uint8), image)


def test_the_drawing_process_draws_and_ends():
    worker = SceneWorker(SceneSetup(CONFIG.scene, CAMERAS, URDF_FILE, window=False))
    try:
        assert worker.picture(SceneState(HOME, REST)).startswith(b"\x89PNG")
    finally:
        worker.close()
    with pytest.raises(SceneLostError):
        worker.picture(SceneState(HOME, REST))


@pytest.mark.parametrize(
    ("display", "installed", "words"),
    [
        ("", [], "DISPLAY is not set"),
        (":9", ["libX11.so.6"], "libGL.so.1: apt-get install --no-install-recommends libgl1, or"),
        (":9", [], "libGL.so.1 and libX11.so.6: apt-get .* libgl1 libx11-6, or"),
        (":9", ["libGL.so.1", "libX11.so.6"], "nothing answers at DISPLAY=:9"),
    ],
)
def test_a_window_that_cannot_open_is_refused_with_the_reason(
    monkeypatch, display, installed, words
):
    monkeypatch.setenv("DISPLAY", display)
    monkeypatch.setattr(window, "_is_installed", lambda name: name in installed)
    monkeypatch.setattr(window, "_opens", lambda _: False)
    with pytest.raises(SceneLostError, match=words):
        SceneWorker(SceneSetup(CONFIG.scene, CAMERAS, URDF_FILE, window=True))


def test_libraries_and_screens_that_are_not_there_are_found():
    assert window._is_installed("libc.so.6") and not window._is_installed("libNone.so.1")
    assert not window._is_installed("libX11.so.6") or not window._opens(":99991")


def test_a_scene_that_cannot_be_drawn_says_why(tmp_path):
    worker = SceneWorker(SceneSetup(CONFIG.scene, CAMERAS, tmp_path / "none.urdf", window=False))
    with pytest.raises(SceneLostError, match="no robot model"):
        worker.wait_until_up()


def test_a_process_that_does_not_answer_is_ended(monkeypatch):
    monkeypatch.setattr("rst_control.simulation.rendering.worker.START_LIMIT", 0.0)
    worker = SceneWorker(SceneSetup(CONFIG.scene, CAMERAS, URDF_FILE, window=False))
    with pytest.raises(SceneLostError, match="no answer for 0 s"):
        worker.picture(SceneState(HOME, REST))
    assert worker._process.returncode == -signal.SIGKILL
