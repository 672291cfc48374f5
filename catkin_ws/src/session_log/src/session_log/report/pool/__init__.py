# SPDX-License-Identifier: BSD-3-Clause
"""Many sessions together: reduced in other processes, kept, and pooled."""
