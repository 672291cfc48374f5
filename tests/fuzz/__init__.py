# SPDX-License-Identifier: BSD-3-Clause
"""Coverage-guided fuzzing of all that is read from others: `make fuzz SECONDS=60`."""
