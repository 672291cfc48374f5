# SPDX-License-Identifier: BSD-3-Clause
"""The whole simulated system at work: its control loop, its page, and what running it costs."""
