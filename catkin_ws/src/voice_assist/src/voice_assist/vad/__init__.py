# SPDX-License-Identifier: BSD-3-Clause
"""Where speech starts and ends."""
