# SPDX-License-Identifier: BSD-3-Clause
"""Remember: every session in one MCAP file, and what can be read from it.

A name below is loaded when it is first used. `examples/session_to_data_frame.py` uses some.
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from session_log.errors import SessionLogError
    from session_log.export.arrays import read_columns
    from session_log.export.export import export_topics
    from session_log.mcap_file.decoder import Decoder
    from session_log.mcap_file.reader import SessionReader
    from session_log.mcap_file.recover import recover
    from session_log.mcap_file.summary import RecordingSummary, read_summary
    from session_log.mcap_file.writer import SessionWriter
    from session_log.report.one_session import write_report
    from session_log.types import Message, MessageSource

__all__ = [
    "Decoder",
    "Message",
    "MessageSource",
    "RecordingSummary",
    "SessionLogError",
    "SessionReader",
    "SessionWriter",
    "export_topics",
    "read_columns",
    "read_summary",
    "recover",
    "write_report",
]

_HOMES = {
    "Decoder": "mcap_file.decoder",
    "Message": "types",
    "RecordingSummary": "mcap_file.summary",
    "SessionLogError": "errors",
    "SessionReader": "mcap_file.reader",
    "SessionWriter": "mcap_file.writer",
    "MessageSource": "types",
    "export_topics": "export.export",
    "read_columns": "export.arrays",
    "read_summary": "mcap_file.summary",
    "recover": "mcap_file.recover",
    "write_report": "report.one_session",
}


def __getattr__(name: str) -> object:
    """Load a public name from its room."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)
