# SPDX-License-Identifier: BSD-3-Clause
"""A sheet as a lattice of point masses joined by damped springs, stepped by one compiled loop."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

Points = NDArray[np.float64]  # (n, 3), [m]
Indices = NDArray[np.int64]  # (n,)

# Beside the four neighbours (strength 1), diagonals resist shear, second nodes resist folding.
LINKS = (((1, 0), 1.0), ((0, 1), 1.0), ((1, 1), 0.5), ((1, -1), 0.5), ((2, 0), 0.1), ((0, 2), 0.1))
COMPRESSION = (
    0.2  # a link pushes with this share of its pull stiffness: a real sheet wrinkles instead
)


@dataclass(frozen=True, eq=False)
class Edges:
    """The springs of a lattice; entry e joins node first[e] to node second[e]."""

    first: Indices
    second: Indices
    rest: NDArray[np.float64]  # [m]
    strength: NDArray[np.float64]  # [-], times the lattice's stiffness in N/m

    @classmethod
    def between(cls, points: Points, columns: int, rows: int) -> Edges:
        """Join the neighbours of a grid; node (column, row) has the index column * rows + row."""
        first, second, strength = [], [], []
        for (across, along), share in LINKS:
            for column in range(columns - across):
                for row in range(max(0, -along), min(rows, rows - along)):
                    first.append(column * rows + row)
                    second.append((column + across) * rows + row + along)
                    strength.append(share)
        a, b = np.array(first), np.array(second)
        rest = np.linalg.norm(points[b] - points[a], axis=1)
        return cls(a, b, rest, np.array(strength))

    @property
    def count_at_node(self) -> float:
        """Largest sum of strengths that meet at one node [-]; it bounds the fastest vibration."""
        nodes = np.concatenate([self.first, self.second])
        return float(np.bincount(nodes, np.tile(self.strength, 2)).max())


@dataclass(frozen=True)
class Material:
    """What moves the nodes."""

    stiffness: float  # [N/m] of a link of strength 1
    mass: float  # [kg] of a node
    damping: float  # [N s/m] of a link of strength 1
    drag: float  # [1/s] slowing of a node by what surrounds it
    bed: float  # [N/m] pull of each node towards its place at rest


@dataclass(frozen=True, eq=False)
class Impulses:
    """Mean forces over one step, base frame, [N], each of shape (3,)."""

    held: NDArray[np.float64]  # of the lattice on whatever moves the held node
    rim: NDArray[np.float64]  # of the lattice on its fixed nodes
    outside: NDArray[np.float64]  # of drag and bed on the free nodes


@njit(cache=True, nogil=True, error_model="numpy")  # type: ignore[untyped-decorator]
def _link_forces(
    x: Points,
    v: Points,
    first: Indices,
    second: Indices,
    rest: NDArray[np.float64],
    strength: NDArray[np.float64],
    stiffness: float,
    damping: float,
    force: Points,
) -> None:
    force[:] = 0.0
    for e in range(first.size):
        i, j = first[e], second[e]
        dx, dy, dz = x[j, 0] - x[i, 0], x[j, 1] - x[i, 1], x[j, 2] - x[i, 2]
        inverse = 1.0 / (np.sqrt(dx * dx + dy * dy + dz * dz) + 1e-12)
        along = dx * (v[j, 0] - v[i, 0]) + dy * (v[j, 1] - v[i, 1]) + dz * (v[j, 2] - v[i, 2])
        stretch = 1.0 - rest[e] * inverse  # relative to the present length
        push = stiffness * stretch
        if stretch < 0.0:
            push *= COMPRESSION
        pull = strength[e] * (push + damping * along * inverse * inverse)
        force[i, 0] += pull * dx
        force[i, 1] += pull * dy
        force[i, 2] += pull * dz
        force[j, 0] -= pull * dx
        force[j, 1] -= pull * dy
        force[j, 2] -= pull * dz


@njit(cache=True, nogil=True, error_model="numpy")  # type: ignore[untyped-decorator]
def _advance(
    x: Points,
    v: Points,
    home: Points,
    fixed: NDArray[np.bool_],
    first: Indices,
    second: Indices,
    rest: NDArray[np.float64],
    strength: NDArray[np.float64],
    material: tuple[float, float, float, float, float],
    held: int,
    target: NDArray[np.float64],
    duration: float,
    steps: int,
    force: Points,
    sums: Points,
) -> None:
    stiffness, mass, damping, drag, bed = material
    dt = duration / steps
    sums[:] = 0.0
    if held >= 0:
        for axis in range(3):
            v[held, axis] = (target[axis] - x[held, axis]) / duration
    for _ in range(steps):
        _link_forces(x, v, first, second, rest, strength, stiffness, damping, force)
        for n in range(fixed.size):
            for axis in range(3):
                if n == held:
                    sums[0, axis] += force[n, axis] / steps
                    x[n, axis] += v[n, axis] * dt
                elif fixed[n]:
                    sums[1, axis] += force[n, axis] / steps
                else:
                    outside = bed * (home[n, axis] - x[n, axis]) - drag * mass * v[n, axis]
                    sums[2, axis] += outside / steps
                    v[n, axis] += (force[n, axis] + outside) / mass * dt
                    x[n, axis] += v[n, axis] * dt
    if held >= 0:
        x[held] = target


class Lattice:
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
        material: Material,
    ) -> None:
        self.home = np.array(points, dtype=float)
        self.edges = Edges.between(self.home, columns, rows)
        self.fixed, self.material = fixed, material
        self.x, self.v = self.home.copy(), np.zeros_like(self.home)
        self._force, self._sums = np.zeros_like(self.home), np.zeros((3, 3))

    def longest_step(self) -> float:
        """Largest time step to use [s]: 0.7 of the stability limit of the fastest vibration."""
        m, links = self.material, 2.0 * self.edges.count_at_node
        frequency = np.sqrt(m.stiffness * links / m.mass)
        ratio = 0.5 * (m.damping * links / m.mass + m.drag) / frequency
        return float(0.7 * 2.0 * (np.sqrt(1.0 + ratio**2) - ratio) / frequency)

    def advance(
        self, duration: float, steps: int, held: int = -1, target: Any = (0.0, 0.0, 0.0)
    ) -> Impulses:
        """Move on in time.

        Args:
            duration: Time to move on by [s].
            steps: Sub-steps of the integration.
            held: Node that is led in a straight line to `target`; -1 for none.
            target: Where it is led to, base frame, [m]. Shape (3,).
        """
        m, e = self.material, self.edges
        _advance(
            self.x,
            self.v,
            self.home,
            self.fixed,
            e.first,
            e.second,
            e.rest,
            e.strength,
            (m.stiffness, m.mass, m.damping, m.drag, m.bed),
            held,
            np.asarray(target, dtype=float),
            duration,
            steps,
            self._force,
            self._sums,
        )
        return Impulses(*self._sums.copy())

    def strains(self) -> NDArray[np.float64]:
        """Relative lengthening of every link [-]."""
        e = self.edges
        length: NDArray[np.float64] = np.linalg.norm(self.x[e.second] - self.x[e.first], axis=1)
        return length / e.rest - 1.0

    def reset(self) -> None:
        """Put every node back to rest."""
        self.x[:], self.v[:] = self.home, 0.0
