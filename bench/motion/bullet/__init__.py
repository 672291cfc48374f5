# SPDX-License-Identifier: BSD-3-Clause
"""PyBullet as a second opinion on kinematics and distances."""
