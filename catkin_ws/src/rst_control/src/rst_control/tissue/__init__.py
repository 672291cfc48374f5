# SPDX-License-Identifier: BSD-3-Clause
"""The sheet of tissue, and where and how it can be grasped."""
