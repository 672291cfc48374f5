# SPDX-License-Identifier: BSD-3-Clause
"""The nodes of a real or stood-in Kinova Gen3."""
