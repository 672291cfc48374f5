# SPDX-License-Identifier: BSD-3-Clause
"""What launches and nodes share of their start."""
