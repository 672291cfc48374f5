# SPDX-License-Identifier: BSD-3-Clause
"""A sheet of tissue fixed at its rim: jaws hold it at a point, pull, and feel a force."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from rst_control.config import TissueConfig
from rst_control.simulation.mass_spring import MassSpringSheet, SheetMaterial
from rst_control.tissue.sheet import rest_points, rim_nodes
from rst_control.types import Vector

NOTHING = np.zeros(3)
RELAXATION_STEPS = 4000  # of calibration: the slowest vibration has died out by then
REST_STRIDE = 64  # steps between checks whether a free sheet has come to rest
REST_SPEED = 1e-7  # [m/s]


class SimulatedTissue:
    """A deformable sheet, stepped in time beside the robot.

    Held tissue keeps its place relative to the tool tip, so taking hold changes no force.

    Args:
        config: Size, place, material and rim of the sheet.
        step: Time of one `advance` [s].
    """

    def __init__(self, config: TissueConfig, step: float) -> None:
        self.config, self.step = config, step
        points, fixed = rest_points(config), rim_nodes(config)
        self._sheet = MassSpringSheet(
            points, *config.nodes, fixed, _material(config, config.stiffness)
        )
        self._calibrate()
        self._steps = int(np.ceil(step / self._sheet.longest_step()))
        self._held, self._offset = -1, NOTHING
        self.taken_at = NOTHING  # (3,), base frame, [m]: the tool tip when it took hold last
        self._free_steps, self._is_at_rest = 0, True

    @property
    def is_held(self) -> bool:
        """Whether the jaws hold the sheet."""
        return self._held >= 0

    @property
    def held_node(self) -> int:
        """Number of the node that the jaws hold; -1: none."""
        return self._held

    @property
    def nodes(self) -> NDArray[np.float64]:
        """Places of the nodes now, base frame, [m]. Shape (columns * rows, 3), a copy."""
        return self._sheet.x.copy()

    @property
    def rim(self) -> NDArray[np.bool_]:
        """Which nodes are fixed. Shape (columns * rows,), a copy."""
        return self._sheet.fixed.copy()

    @property
    def max_strain(self) -> float:
        """Largest relative lengthening of any link [-]."""
        return float(self._sheet.strains().max())

    def grasp(self, tip: Vector) -> bool:
        """Take hold of the node nearest to the tool tip.

        Args:
            tip: Tool tip, base frame, [m]. Shape (3,).

        Returns:
            False, and holds nothing, where no free node lies within the grasp radius.
        """
        distance = np.linalg.norm(self._sheet.x - tip, axis=1)
        distance[self._sheet.fixed] = np.inf
        nearest = int(distance.argmin())
        if distance[nearest] > self.config.grasp_radius:
            return False
        self._held, self._offset = nearest, self._sheet.x[nearest] - tip
        self.taken_at = np.array(tip)
        self._is_at_rest = False
        return True

    def release(self) -> None:
        """Let go; from now on the jaws feel nothing."""
        if not self.is_held:
            return
        self._sheet.v[self._held] = 0.0
        self._held, self._free_steps = -1, 0

    def advance(self, tip: Vector) -> Vector:
        """Move on by one step; held tissue follows the tool tip.

        Args:
            tip: Tool tip at the end of the step, base frame, [m]. Shape (3,).

        Returns:
            Force of the tissue on the jaws, base frame, [N]. Shape (3,).
        """
        if self._is_at_rest:
            return NOTHING
        force = self._sheet.advance(self.step, self._steps, self._held, tip + self._offset)
        if not self.is_held:
            self._check_rest()
        return force

    def reset(self) -> None:
        """Let go and lie down as at the start."""
        self.release()
        self._sheet.reset()
        self._is_at_rest = True

    def _check_rest(self) -> None:
        self._free_steps += 1
        if self._free_steps % REST_STRIDE == 0:
            self._is_at_rest = bool(np.abs(self._sheet.v).max() < REST_SPEED)

    def _calibrate(self) -> None:
        """Scale the links until the pull at the reference point has the stiffness asked for."""
        config, sheet = self.config, self._sheet
        point = np.array(config.reference_point)
        distance = np.linalg.norm(sheet.home - point, axis=1)
        distance[sheet.fixed] = np.inf
        pull = np.array(config.reference_pull)
        target = sheet.home[int(distance.argmin())] + pull
        sheet.material = replace(sheet.material, bed=0.0)
        step = sheet.longest_step()
        for share in np.linspace(0.0, 1.0, RELAXATION_STEPS // 4):
            sheet.advance(step, 1, int(distance.argmin()), target - (1.0 - share) * pull)
        for _ in range(RELAXATION_STEPS):
            felt = sheet.advance(step, 1, int(distance.argmin()), target)
        secant = -float(felt @ pull) / float(pull @ pull)
        sheet.material = _material(config, config.stiffness**2 / secant)
        sheet.reset()


def _material(config: TissueConfig, stiffness: float) -> SheetMaterial:
    area, count = config.size[0] * config.size[1], config.nodes[0] * config.nodes[1]
    sheet = config.density * area
    mass = sheet / count
    return SheetMaterial(
        stiffness=stiffness,
        mass=mass,
        damping=2.0 * config.damping_ratio * float(np.sqrt(stiffness * mass)),
        drag=2.0 * float(np.sqrt(stiffness / sheet)),
        bed=config.bed_stiffness / count,
    )


class Jaws:
    """Watches the opening of the jaws; tissue is taken only by jaws that were open before.

    Args:
        tissue: What may be taken.
        closed_opening: Closed below this [rad].
        held_opening: Open beyond this [rad].
    """

    def __init__(self, tissue: SimulatedTissue, closed_opening: float, held_opening: float) -> None:
        self._tissue = tissue
        self._closed, self._open = closed_opening, held_opening
        self._were_open = False

    def follow(self, opening: float, tip: NDArray[np.float64]) -> None:
        """Take or let go of the tissue as the jaws now stand.

        Args:
            opening: Angle between the jaws [rad].
            tip: Point between their tips, base frame, [m]. Shape (3,).
        """
        if opening > self._open:
            self._were_open = True
            self._tissue.release()
        elif opening < self._closed and self._were_open:
            self._were_open = False
            self._tissue.grasp(tip)
