# SPDX-License-Identifier: BSD-3-Clause
"""What each command does, and when it is refused."""
