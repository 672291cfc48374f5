# SPDX-License-Identifier: BSD-3-Clause
"""Figures of tension by joint torques."""
