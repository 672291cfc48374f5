# SPDX-License-Identifier: BSD-3-Clause
"""Robots that the controller can move: the seam, a fake for tests, and the simulation."""
