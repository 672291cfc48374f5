# SPDX-License-Identifier: BSD-3-Clause
"""The node of the pedals."""
