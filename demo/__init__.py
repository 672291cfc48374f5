# SPDX-License-Identifier: BSD-3-Clause
"""The main job, shown: a spoken session moves the simulated robot and leaves a recording."""
