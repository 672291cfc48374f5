# SPDX-License-Identifier: BSD-3-Clause
"""From measured forces to the tension of the tissue, and its control."""
