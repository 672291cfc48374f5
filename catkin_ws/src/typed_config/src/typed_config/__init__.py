# SPDX-License-Identifier: BSD-3-Clause
"""Settings that fail at start: YAML into frozen dataclasses, each key with its range and unit."""

from typed_config.fields import choice, flag, integer, items, number, text
from typed_config.loader import ConfigError, load_config, load_yaml

__all__ = [
    "ConfigError",
    "choice",
    "flag",
    "integer",
    "items",
    "load_config",
    "load_yaml",
    "number",
    "text",
]
