# SPDX-License-Identifier: BSD-3-Clause
"""Whether the simulated tissue is triangulated as it is held now."""

from __future__ import annotations

import numpy as np

from rst_control.config import SceneConfig
from rst_control.simulation.tissue import SimulatedTissue
from rst_control.tissue.triangulation import Triangulation, triangulation
from rst_control.types import Vector


def exposure(tissue: SimulatedTissue, scene: SceneConfig, force: Vector) -> Triangulation | None:
    """Judge the sheet in the jaws; None where they hold none.

    Args:
        tissue: As it is now.
        scene: With the point that should have been grasped.
        force: Of the tissue on the jaws, base frame, [N]. Shape (3,).
    """
    if not tissue.is_held:
        return None
    nodes = tissue.nodes
    return triangulation(
        nodes,
        tissue.rim,
        nodes[tissue.held_node],
        np.array(scene.grasp_point) - tissue.taken_at,
        float(np.linalg.norm(force)),
        tissue.max_strain,
    )


def exposure_words(held: Triangulation | None, scene: SceneConfig) -> str:
    """The verdict for people: what is not as `scene.triangulation` asks, with its values."""
    if held is None:
        return "no tissue held"
    failures = held.failures(scene.triangulation)
    return f"not triangulated: {'; '.join(failures)}" if failures else "triangulated"
