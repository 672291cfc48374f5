# SPDX-License-Identifier: BSD-3-Clause
"""A search over all sequences of events."""
