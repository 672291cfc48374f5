# SPDX-License-Identifier: BSD-3-Clause
"""A second way to a stop: a small network of its own that listens for one word."""
