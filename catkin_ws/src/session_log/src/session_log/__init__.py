# SPDX-License-Identifier: BSD-3-Clause
"""Remember: every session in one MCAP file, and what can be read from it."""
