# SPDX-License-Identifier: BSD-3-Clause
"""A sheet as a grid of point masses joined by damped springs, stepped by one compiled loop.

Links of one kind join every node to the one a fixed number of places further on, so that all loops
run along arrays without an index list, and the compiler takes four or eight nodes at a time.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rst_control.kernels import kernel

Points = NDArray[np.float64]  # (n, 3), [m]
Rows = NDArray[np.float64]  # (3, n): the same points, one axis after the other

# Beside the four neighbours (strength 1), diagonals resist shear, second nodes resist folding.
LINKS = (((1, 0), 1.0), ((0, 1), 1.0), ((1, 1), 0.5), ((1, -1), 0.5), ((2, 0), 0.1), ((0, 2), 0.1))
COMPRESSION = 0.2  # share of its pull stiffness with which a link pushes: real sheets wrinkle
NO_LINK = 1.0  # [m] rest length where a kind has no link; its strength is zero


@dataclass(frozen=True, eq=False)
class Links:
    """The springs of a sheet: link (kind, n) joins node n to node n + offset[kind]."""

    offset: NDArray[np.int64]  # (kinds,)
    rest: NDArray[np.float64]  # (kinds, n), [m]
    strength: NDArray[np.float64]  # (kinds, n), times the sheet's stiffness; 0: no link

    @classmethod
    def between(cls, points: Points, columns: int, rows: int) -> Links:
        """Join the neighbours of a grid; node (column, row) has the index column * rows + row."""
        node = np.arange(columns * rows).reshape(columns, rows)
        offset = np.array([across * rows + along for (across, along), _ in LINKS])
        rest = np.full((len(LINKS), columns * rows), NO_LINK)
        strength = np.zeros_like(rest)
        for kind, ((across, along), share) in enumerate(LINKS):
            first = node[: columns - across, max(0, -along) : min(rows, rows - along)].ravel()
            span = points[first + offset[kind]] - points[first]
            rest[kind, first] = np.linalg.norm(span, axis=1)
            strength[kind, first] = share
        return cls(offset, rest, strength)

    @property
    def count_at_node(self) -> float:
        """Largest sum of strengths that meet at one node [-]; it bounds the fastest vibration."""
        total = self.strength.sum(axis=0)
        for offset, strength in zip(self.offset, self.strength, strict=True):
            total[offset:] += strength[: len(total) - offset]
        return float(total.max())

    def strains(self, points: Points) -> NDArray[np.float64]:
        """Relative lengthening of every link with its nodes at `points` [m]."""
        kind, first = np.nonzero(self.strength)
        span = points[first + self.offset[kind]] - points[first]
        length: NDArray[np.float64] = np.linalg.norm(span, axis=1)
        return length / self.rest[kind, first] - 1.0


@dataclass(frozen=True)
class SheetMaterial:
    """What moves the nodes."""

    stiffness: float  # [N/m] of a link of strength 1
    mass: float  # [kg] of a node
    damping: float  # [N s/m] of a link of strength 1
    drag: float  # [1/s] slowing of a node by what surrounds it
    bed: float  # [N/m] pull of each node towards its place at rest


@partial(kernel, error_model="numpy")
def _link_forces(
    x: Rows,
    v: Rows,
    offset: NDArray[np.int64],
    rest: NDArray[np.float64],
    strength: NDArray[np.float64],
    stiffness: float,
    damping: float,
    force: Rows,
    pull: Rows,
) -> None:
    """Write the links' force on each node into `force`; `pull` is scratch."""
    force[:] = 0.0
    for kind in range(offset.size):
        count = x.shape[1] - offset[kind]
        x0, y0, z0 = x[0, :count], x[1, :count], x[2, :count]
        x1, y1, z1 = x[0, offset[kind] :], x[1, offset[kind] :], x[2, offset[kind] :]
        u0, v0, w0 = v[0, :count], v[1, :count], v[2, :count]
        u1, v1, w1 = v[0, offset[kind] :], v[1, offset[kind] :], v[2, offset[kind] :]
        length, share = rest[kind], strength[kind]
        px, py, pz = pull[0], pull[1], pull[2]
        for n in range(count):
            dx, dy, dz = x1[n] - x0[n], y1[n] - y0[n], z1[n] - z0[n]
            inverse = 1.0 / (np.sqrt(dx * dx + dy * dy + dz * dz) + 1e-12)
            along = dx * (u1[n] - u0[n]) + dy * (v1[n] - v0[n]) + dz * (w1[n] - w0[n])
            stretch = 1.0 - length[n] * inverse  # relative to the present length
            push = stiffness * stretch * (COMPRESSION if stretch < 0.0 else 1.0)
            tension = share[n] * (push + damping * along * inverse * inverse)
            px[n], py[n], pz[n] = tension * dx, tension * dy, tension * dz
        for axis in range(3):
            here, there, along_axis = force[axis, :count], force[axis, offset[kind] :], pull[axis]
            for n in range(count):
                here[n] += along_axis[n]
            for n in range(count):
                there[n] -= along_axis[n]


@partial(kernel, error_model="numpy")
def _advance(
    x: Rows,
    v: Rows,
    home: Rows,
    free: NDArray[np.float64],
    offset: NDArray[np.int64],
    rest: NDArray[np.float64],
    strength: NDArray[np.float64],
    material: tuple[float, float, float, float, float],
    held: int,
    target: NDArray[np.float64],
    duration: float,
    steps: int,
    scratch: NDArray[np.float64],
    felt: NDArray[np.float64],
) -> None:
    """Move on by `steps` equal steps; what is fixed or held has no freedom and keeps its speed.

    Writes the links' mean force on the held node into `felt` (3,).
    """
    stiffness, mass, damping, drag, bed = material
    dt = duration / steps
    force, pull = scratch[0], scratch[1]
    felt[:] = 0.0
    if held >= 0:
        free[held] = 0.0
        for axis in range(3):
            v[axis, held] = (target[axis] - x[axis, held]) / duration
    for _ in range(steps):
        _link_forces(x, v, offset, rest, strength, stiffness, damping, force, pull)
        for axis in range(3):
            xa, va, ha, fa = x[axis], v[axis], home[axis], force[axis]
            if held >= 0:
                felt[axis] += fa[held]
            for n in range(free.size):
                outside = free[n] * (bed * (ha[n] - xa[n]) - drag * mass * va[n])
                va[n] += (free[n] * fa[n] + outside) * (dt / mass)
                xa[n] += va[n] * dt
    if held >= 0:
        free[held] = 1.0
        for axis in range(3):
            felt[axis] /= steps
            x[axis, held] = target[axis]


class MassSpringSheet:
    """Node positions and speeds, stepped in time; some nodes are fixed, one may be held and moved.

    Args:
        points: Places at rest, base frame, [m]. Shape (columns * rows, 3).
        columns: Nodes along the first side.
        rows: Nodes along the second side.
        fixed: Which nodes never move. Shape (columns * rows,).
        material: What moves the nodes.
    """

    def __init__(
        self,
        points: Points,
        columns: int,
        rows: int,
        fixed: NDArray[np.bool_],
        material: SheetMaterial,
    ) -> None:
        self._home = np.array(points.T, dtype=float, order="C")
        self._x, self._v = self._home.copy(), np.zeros_like(self._home)
        self.home, self.x, self.v = self._home.T, self._x.T, self._v.T  # (n, 3), of the same data
        self.links = Links.between(self.home, columns, rows)
        self.fixed, self.material = fixed, material
        self._free = (~fixed).astype(float)
        self._scratch, self._felt = np.zeros((2, *self._home.shape)), np.zeros(3)

    def longest_step(self) -> float:
        """Largest time step to use [s]: 0.7 of the stability limit of the fastest vibration."""
        m, links = self.material, 2.0 * self.links.count_at_node
        frequency = np.sqrt(m.stiffness * links / m.mass)
        ratio = 0.5 * (m.damping * links / m.mass + m.drag) / frequency
        return float(0.7 * 2.0 * (np.sqrt(1.0 + ratio**2) - ratio) / frequency)

    def advance(
        self, duration: float, steps: int, held: int = -1, target: Any = (0.0, 0.0, 0.0)
    ) -> NDArray[np.float64]:
        """Move on in time.

        Args:
            duration: Time to move on by [s].
            steps: Sub-steps of the integration.
            held: Node that is led in a straight line to `target`; -1 for none.
            target: Where it is led to, base frame, [m]. Shape (3,).

        Returns:
            Mean force of the sheet on whatever holds the node, base frame, [N]. Shape (3,).
        """
        m, links = self.material, self.links
        _advance(
            self._x,
            self._v,
            self._home,
            self._free,
            links.offset,
            links.rest,
            links.strength,
            (m.stiffness, m.mass, m.damping, m.drag, m.bed),
            held,
            np.asarray(target, dtype=float),
            duration,
            steps,
            self._scratch,
            self._felt,
        )
        return self._felt.copy()

    def strains(self) -> NDArray[np.float64]:
        """Relative lengthening of every link [-]."""
        return self.links.strains(self.x)

    def reset(self) -> None:
        """Put every node back to rest."""
        self.x[:], self.v[:] = self.home, 0.0
