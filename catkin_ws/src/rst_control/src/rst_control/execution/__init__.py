# SPDX-License-Identifier: BSD-3-Clause
"""The control loop: state machine, phases and set-points."""
