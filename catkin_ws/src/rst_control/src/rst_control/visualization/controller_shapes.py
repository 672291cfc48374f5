# SPDX-License-Identifier: BSD-3-Clause
"""What a viewer shows of the controller: trocar, plan, limits of the workspace, tension."""

from __future__ import annotations

import numpy as np

from rst_control.config import MotionConfig, SceneConfig
from rst_control.execution.snapshot import ControllerSnapshot
from rst_control.kinematics.configuration import Configuration, planning_joints
from rst_control.kinematics.robot_model import RobotModel
from rst_control.trajectory.path import Path
from rst_control.types import Vector, frozen_array
from rst_control.visualization.shapes import Colour, Points, Shape, ShapeKind, circle
from rst_control.visualization.tip_route import PER_KNOT, RoutePart, route, tips

TROCAR: Colour = (0.84, 0.37, 0.00, 1.0)
AHEAD: Colour = (0.00, 0.45, 0.70, 1.0)
TRAVELLED: Colour = (0.55, 0.60, 0.65, 1.0)
GRASP: Colour = (0.80, 0.47, 0.65, 1.0)
WORKSPACE: Colour = (0.20, 0.45, 0.65, 0.12)
INK: Colour = (0.12, 0.16, 0.20, 1.0)
GREEN: Colour = (0.00, 0.62, 0.45, 1.0)
AMBER: Colour = (0.90, 0.62, 0.00, 1.0)
RED: Colour = (0.80, 0.10, 0.10, 1.0)

RING_RADIUS, RING_SIDES = 0.012, 32  # [m] of the trocar
BALL, LINE = 0.006, 0.0020  # [m] diameter of trocar and grasp point; width of lines
SHAFT_SHOWN = 0.045  # [m] of the shaft's line, either side of the trocar
ARROW_SCALE = 0.05  # [m/N] of the tension's arrow
ARROW_WIDTH, LETTER = 0.006, 0.020  # [m]
MIN_TENSION = 0.01  # [N] below which there is no arrow
RCM_LABEL = (0.100, 0.0, 0.012)  # [m] from the trocar to its label
TENSION_LABEL = (0.185, 0.0, 0.0)  # [m] from the tip to its label


class ControllerShapes:
    """Makes the shapes of one moment.

    Args:
        model: The robot.
        config: Its limits of tension.
    """

    def __init__(self, model: RobotModel, config: MotionConfig) -> None:
        self._model = model
        self._tension = config.controller.tension

    def __call__(self, view: ControllerSnapshot, scene: SceneConfig) -> list[Shape]:
        """Shapes of a state, base frame.

        Args:
            view: The controller's state.
            scene: The active trocar and grasp point.
        """
        trocar = np.array(scene.trocar)
        shapes = [*_places(scene), *self._way(view, trocar)]
        if view.measurement is None:
            return [*shapes, *_trocar(trocar, np.array([0.0, 0.0, 1.0]))]
        q, _ = planning_joints(view.measurement.position)
        here = Configuration(self._model, q)
        shapes += _trocar(trocar, here.T_base_shaft[:3, 2])
        shapes.append(_label("rcm error", trocar + RCM_LABEL, rcm_words(view.rcm_error)))
        return [*shapes, *self._pull(view, here.tip)]

    def colour_of(self, tension: float) -> Colour:
        """Green up to the most that may be asked for [N], red above the limit, amber between."""
        if tension > self._tension.limit:
            return RED
        return AMBER if tension > self._tension.maximum + self._tension.tolerance else GREEN

    def _way(self, view: ControllerSnapshot, trocar: Vector) -> list[Shape]:
        def tips_of(path: Path) -> tuple[Points, Points]:
            samples = path.sample(self._model.chain, trocar, PER_KNOT)
            return samples.s, samples.tip

        def line(name: str, parts: tuple[RoutePart, ...], colour: Colour) -> list[Shape]:
            if not parts:
                return []
            points = np.vstack([tips(part, tips_of) for part in parts])
            return [Shape(name, ShapeKind.LINE, points, LINE, colour)]

        way = route(view)
        travelled = line("path travelled", way.travelled, TRAVELLED)
        return travelled + line("path ahead", way.ahead, AHEAD)

    def _pull(self, view: ControllerSnapshot, tip: Vector) -> list[Shape]:
        words = tension_words(view)
        shapes = [_label("tension words", tip + TENSION_LABEL, words)]
        tension = view.tension
        if view.measurement is not None and tension > MIN_TENSION:
            ends = np.array([tip, tip + ARROW_SCALE * view.measurement.force])
            shapes.append(
                Shape("tension", ShapeKind.ARROW, ends, ARROW_WIDTH, self.colour_of(tension))
            )
        return shapes


def _places(scene: SceneConfig) -> list[Shape]:
    centre, grasp = (np.array([p]) for p in (scene.workspace_centre, scene.grasp_point))
    return [
        Shape("workspace", ShapeKind.BALLS, centre, 2.0 * scene.workspace_radius, WORKSPACE),
        Shape("grasp point", ShapeKind.BALLS, grasp, BALL, GRASP),
    ]


def tension_words(view: ControllerSnapshot) -> str:
    """Tension, where it is to go, and the state: "1.02 N -> 1.25 N, active"."""
    goal = f" -> {view.tension_target:.2f} N" if view.tension_target else ""
    return f"{view.tension:.2f} N{goal}, {view.mode.state.value}"


def rcm_words(error: float) -> str:
    """Distance of the shaft from the trocar [m] in words for people."""
    return f"RCM {1e6 * error:.2f} um"


def _trocar(trocar: Vector, along: Vector) -> list[Shape]:
    ring = circle(trocar, RING_RADIUS, (0.0, 0.0, 1.0), RING_SIDES)
    axis = np.array([trocar - SHAFT_SHOWN * along, trocar + SHAFT_SHOWN * along])
    return [
        Shape("trocar", ShapeKind.BALLS, frozen_array([trocar], 1, 3), BALL, TROCAR),
        Shape("trocar ring", ShapeKind.LINE, ring, LINE, TROCAR),
        Shape("shaft line", ShapeKind.LINE, axis, 0.5 * LINE, TROCAR),
    ]


def _label(name: str, place: Vector, words: str) -> Shape:
    return Shape(name, ShapeKind.LABEL, np.array([place]), LETTER, INK, text=words)
