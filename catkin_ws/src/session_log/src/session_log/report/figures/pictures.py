# SPDX-License-Identifier: BSD-3-Clause
"""Pictures of the scene over the session."""

from __future__ import annotations

import io
import math

import matplotlib.image
import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from session_log.report.figures.figure import SessionFigure, SessionMaterial
from session_log.report.figures.style import Layout, new_figure
from session_log.report.session.session_data import RecordedPicture


class PicturesFigure(SessionFigure):
    """A sheet of pictures, each with its time."""

    name = "scene"
    title = "The scene"
    lacking = "The recording holds no pictures of the scene, or none are asked for (pictures: 0)."

    def can_draw(self, material: SessionMaterial) -> bool:
        """Whether a readable picture was recorded and is wanted."""
        return bool(_evenly_chosen(material))

    def caption(self, material: SessionMaterial) -> str:
        """Say where they come from."""
        topic = material.config.topics.picture
        return f"Pictures from {topic}, with the time since the session began."

    def draw(self, material: SessionMaterial, layout: Layout) -> Figure:
        """Draw the pictures in rows."""
        shown = _evenly_chosen(material)
        columns = min(layout.columns, len(shown))
        rows = math.ceil(len(shown) / columns)
        height, width = shown[0][1].shape[:2]
        cell = layout.width / columns
        figure = new_figure(layout, rows * (cell * height / width + 0.2))
        axes = figure.subplots(rows, columns, squeeze=False).ravel()
        for ax in axes:
            ax.set_axis_off()
        for ax, (time, image) in zip(axes, shown, strict=False):
            white = 255.0 if image.dtype == np.uint8 else 1.0
            ax.imshow(image, interpolation="antialiased", cmap="gray", vmin=0, vmax=white)
            ax.set_title(f"{time:.1f} s", pad=2)
        return figure


def _evenly_chosen(material: SessionMaterial) -> list[tuple[float, NDArray[np.generic]]]:
    read = [(p.time, _image(p)) for p in material.data.pictures]
    good = [(time, image) for time, image in read if image is not None]
    count = min(material.config.pictures, len(good))
    return [good[int(i)] for i in np.linspace(0, len(good) - 1, count).round()]


def _image(picture: RecordedPicture) -> NDArray[np.generic] | None:
    kind = "jpeg" if "jp" in picture.format else "png"
    try:
        return np.asarray(matplotlib.image.imread(io.BytesIO(picture.data), format=kind))
    except (OSError, ValueError, SyntaxError):
        return None
