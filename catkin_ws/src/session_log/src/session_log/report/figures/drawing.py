# SPDX-License-Identifier: BSD-3-Clause
"""Draws figures for both widths and writes them beside the page."""

from __future__ import annotations

import io
from collections.abc import Sequence
from pathlib import Path
from typing import TypeVar

import matplotlib as mpl
import matplotlib.style
from matplotlib.backends.backend_agg import FigureCanvasAgg

from session_log.config import ReportConfig
from session_log.report.figures import ReportFigure, fonts
from session_log.report.figures.style import NARROW, RC, WIDE, Layout
from session_log.report.page import Image

M = TypeVar("M")


def draw(
    figures: Sequence[ReportFigure[M]], material: M, folder: Path, config: ReportConfig
) -> tuple[dict[str, Image], list[Path]]:
    """Draw every figure that the material has something for, and write it as PNG.

    Returns:
        The drawn figures by name, and the files written.

    Raises:
        OSError: The folder cannot be written.
    """
    images, written = {}, []
    with mpl.style.context({**RC, "font.family": fonts.families()}), fonts.glyphs_named_once():
        for figure in figures:
            if not figure.can_draw(material):
                continue
            image = _image(figure, material, config)
            images[figure.name] = image
            path = folder / f"{figure.name}.png"
            path.write_bytes(image.wide)
            written.append(path)
            if config.vector:
                vector = path.with_suffix(".pdf")
                figure.draw(material, WIDE).savefig(vector)
                written.append(vector)
    return images, written


def _image(figure: ReportFigure[M], material: M, config: ReportConfig) -> Image:
    return Image(
        title=figure.title,
        caption=figure.caption(material),
        wide=_png(figure, material, WIDE, config.resolution),
        narrow=_png(figure, material, NARROW, config.resolution),
    )


def _png(figure: ReportFigure[M], material: M, layout: Layout, resolution: int) -> bytes:
    drawn = figure.draw(material, layout)
    FigureCanvasAgg(drawn)
    buffer = io.BytesIO()
    drawn.savefig(buffer, format="png", dpi=resolution)
    return buffer.getvalue()
