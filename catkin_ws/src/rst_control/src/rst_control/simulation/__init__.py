# SPDX-License-Identifier: BSD-3-Clause
"""The simulated robot and tissue, on PyBullet."""
