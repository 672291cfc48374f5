# SPDX-License-Identifier: BSD-3-Clause
"""Checked paths: free space, insertion, and motion through the trocar."""
