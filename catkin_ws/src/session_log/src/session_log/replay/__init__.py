# SPDX-License-Identifier: BSD-3-Clause
"""A recorded session heard again."""
