# SPDX-License-Identifier: BSD-3-Clause
"""What bench, paper, demo and tests share."""
