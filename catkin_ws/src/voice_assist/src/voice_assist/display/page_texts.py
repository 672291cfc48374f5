# SPDX-License-Identifier: BSD-3-Clause
"""The page's own words in another language: `texts/<language>.yaml`, by the English ones."""

from __future__ import annotations

from typing import Final

from typed_config import load_yaml, package_folder

TEXTS_DIR: Final = package_folder("voice_assist") / "texts"
ENGLISH: Final = "en"


def page_texts(language: str) -> dict[str, str]:
    """Texts by the English ones; what has no entry stays English.

    Args:
        language: One of `config.display.LANGUAGES`.

    Raises:
        ConfigError: The file is not as it must be.
    """
    return {} if language == ENGLISH else dict(load_yaml(TEXTS_DIR / f"{language}.yaml"))
