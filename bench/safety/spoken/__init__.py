# SPDX-License-Identifier: BSD-3-Clause
"""From the end of a spoken stop to the robot at rest."""
