# SPDX-License-Identifier: BSD-3-Clause
"""From speech, synthetic and human, to the embedded checkpoint."""
