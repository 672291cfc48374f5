# SPDX-License-Identifier: BSD-3-Clause
"""What is said and what sounds beside it, made or found once and kept."""
