# SPDX-License-Identifier: BSD-3-Clause
"""Forward and inverse kinematics under the RCM constraint."""
