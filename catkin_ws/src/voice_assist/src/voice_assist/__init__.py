# SPDX-License-Identifier: BSD-3-Clause
"""Hear: from sound to a surgical command."""
