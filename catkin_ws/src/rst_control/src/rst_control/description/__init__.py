# SPDX-License-Identifier: BSD-3-Clause
"""The robot as numbers, and the URDF that is written from them."""
