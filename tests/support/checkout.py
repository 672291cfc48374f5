# SPDX-License-Identifier: BSD-3-Clause
"""What only a checkout has."""

from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
needs_git = pytest.mark.skipif(
    not (ROOT / ".git").exists(), reason="git lists the files, and the image has no .git"
)
