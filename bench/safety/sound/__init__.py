# SPDX-License-Identifier: BSD-3-Clause
"""Sound that is no speech, and a stop after it."""
