# SPDX-License-Identifier: BSD-3-Clause
"""MCAP files: written so that they survive, read so that nothing is lost."""
