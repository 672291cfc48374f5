# SPDX-License-Identifier: BSD-3-Clause
"""A day of commands, talk and faults, in process."""
