# SPDX-License-Identifier: BSD-3-Clause
"""Recall, false alarms and calibration over labelled sound."""
