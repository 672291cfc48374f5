# SPDX-License-Identifier: BSD-3-Clause
"""What a real arm, tool, sensors and trocar add to the ideal simulation, each effect by itself."""

from rst_control.simulation.plant.body_wall import BodyWall
from rst_control.simulation.plant.lab import LabPlant, PlantInput

__all__ = ["BodyWall", "LabPlant", "PlantInput"]
