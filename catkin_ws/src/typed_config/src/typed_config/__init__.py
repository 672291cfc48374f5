# SPDX-License-Identifier: BSD-3-Clause
"""Settings that fail at start: YAML into frozen dataclasses, each key with its range and unit.

And what else the packages share: where their files and recordings lie, versions, completion.
"""

from typed_config.common_options import (
    add_common_options,
    check_writable,
    count_option,
    number_option,
    place_option,
    replacing,
    run_command,
)
from typed_config.errors import ConfigError
from typed_config.fields import choice, flag, integer, items, number, text
from typed_config.loader import load_config, load_file, with_present_keys
from typed_config.overlay import overlaid
from typed_config.recordings import (
    RECORDING,
    newest_recording,
    number_of,
    numbered_recordings,
)
from typed_config.resources import (
    ResourceMissing,
    package_file,
    package_folder,
    package_version,
    repository,
)
from typed_config.rules import require, require_rising, require_way
from typed_config.strict_yaml import load_yaml

__all__ = [
    "RECORDING",
    "ConfigError",
    "ResourceMissing",
    "add_common_options",
    "check_writable",
    "choice",
    "count_option",
    "flag",
    "integer",
    "items",
    "load_config",
    "load_file",
    "load_yaml",
    "newest_recording",
    "number",
    "number_of",
    "number_option",
    "numbered_recordings",
    "overlaid",
    "package_file",
    "package_folder",
    "package_version",
    "place_option",
    "replacing",
    "repository",
    "require",
    "require_rising",
    "require_way",
    "run_command",
    "text",
    "with_present_keys",
]
