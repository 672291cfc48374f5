# SPDX-License-Identifier: BSD-3-Clause
"""A stream of sound in frames, whatever it comes from."""
