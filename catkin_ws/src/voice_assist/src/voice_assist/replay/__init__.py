# SPDX-License-Identifier: BSD-3-Clause
"""Recorded sound through the pipeline again."""
