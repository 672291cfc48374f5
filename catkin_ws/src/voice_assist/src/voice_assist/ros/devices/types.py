# SPDX-License-Identifier: BSD-3-Clause
"""Classes of messages and services by the name of their type."""

from __future__ import annotations

import importlib
from typing import Any

from voice_assist.errors import CommandsError


def message_class(name: str) -> Any:
    """The class of a message, such as std_msgs/Bool.

    Raises:
        CommandsError: There is none on this machine.
    """
    return _class(name, "msg")


def service_class(name: str) -> Any:
    """The class of a service, such as std_srvs/SetBool.

    Raises:
        CommandsError: There is none on this machine.
    """
    return _class(name, "srv")


def _class(name: str, kind: str) -> Any:
    package, _, short = name.partition("/")
    try:
        return getattr(importlib.import_module(f"{package}.{kind}"), short)
    except (ImportError, AttributeError):
        allowed = f"a {kind} type that is installed here"
        raise CommandsError("type", name, allowed) from None
