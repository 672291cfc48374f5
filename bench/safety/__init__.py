# SPDX-License-Identifier: BSD-3-Clause
"""Figures of safety, part by part."""
