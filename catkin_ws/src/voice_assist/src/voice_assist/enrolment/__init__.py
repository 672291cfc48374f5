# SPDX-License-Identifier: BSD-3-Clause
"""Learning one person's voice: takes, adaptation, thresholds, and the profile that holds them."""
