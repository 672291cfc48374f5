# SPDX-License-Identifier: BSD-3-Clause
"""Takes of one person's voice: what is to be said, and recordings of it, each checked."""
