# SPDX-License-Identifier: BSD-3-Clause
"""Sound in which nobody gives a command: how often one is taken from it."""
