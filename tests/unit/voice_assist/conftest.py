# SPDX-License-Identifier: BSD-3-Clause
"""The shipped recogniser, loaded once; no test changes it."""

import pytest

from voice_assist.recognizer import load_recognizer


@pytest.fixture(scope="session")
def base():
    return load_recognizer()
