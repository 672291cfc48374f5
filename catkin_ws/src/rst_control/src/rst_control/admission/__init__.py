# SPDX-License-Identifier: BSD-3-Clause
"""Who may command, and what must be given before the first motion."""
