# SPDX-License-Identifier: BSD-3-Clause
"""Texts that look like commands, or are meant to break whatever reads them."""

from __future__ import annotations

MEGA = 10_000_000

# Letters of other scripts that look like ours, and ours in other widths, weights and cases.
LIKE = str.maketrans("aeopsmltr", "\u0430\u0435\u043e\u0440\u0455\u043c\u04cf\u03c4\u0433")
WIDE = str.maketrans({chr(c): chr(c + 0xFEE0) for c in range(0x21, 0x7F)})
BOLD = str.maketrans({chr(ord("a") + n): chr(0x1D41A + n) for n in range(26)})

MOTIONS = ("tense", "release", "pull more", "pull less", "insert", "withdraw", "hey robot")


def disguises(command: str) -> tuple[str, ...]:
    """Texts that a person may take for the command, and that are another text."""
    head, tail = command[:2], command[2:]
    texts = (
        command.translate(LIKE),
        command.translate(WIDE),
        command.translate(BOLD),
        command.replace("e", "\u0435", 1),  # one Cyrillic letter
        command.replace("s", "\u017f", 1) if "s" in command else command + "\u017f",  # long s
        *(head + mark + tail for mark in INVISIBLE),
        *(mark + command for mark in INVISIBLE),
        *(command + mark for mark in INVISIBLE),
        "".join(c + "\u0336" for c in command),  # struck out
        "\u202e" + command[::-1],  # shown the other way round
        command.replace(" ", "\u00a0") if " " in command else command + "\u3000",
        command + "\u0301",
        command + "\ud800",
        command + "\x00",
        "\x00" + command,
        command + "\x1f",
        command + " " * 300 + "not now",  # the denial is far away
        "not" + "\t" * 300 + command,
        command + "\u2028don't",
    )
    return tuple(text for text in texts if text != command)


INVISIBLE = (
    "\u200b",  # zero-width space
    "\u200c",
    "\u200d",  # zero-width joiner
    "\u2060",
    "\u00ad",  # soft hyphen
    "\u034f",
    "\u200e",
    "\u200f",  # right to left
    "\u202a",
    "\u202e",
    "\u2066",
    "\ufeff",
    "\ufe0f",
    "\U000e0074",  # a letter among the tags
)

HUGE = (  # a beginning, and what is repeated after it
    ("", "a"),
    ("", "stop "),
    ("", "tense "),
    ("tense", " "),
    ("", "pull more\n"),
    ("", "\u0315\u0300"),  # marks to be put in order, which takes the square of their number
    ("", "\ufdfa"),  # eighteen letters each when it is decomposed
    ("", "9"),
    ("", "a'"),
    ("", "\x00"),
    ("", "\ud800"),
    ("", " "),
    ("", "\U0001f480"),
)


def huge(beginning: str, repeated: str) -> str:
    """Ten million characters."""
    return beginning + repeated * (MEGA // len(repeated))


BROKEN = (
    "",
    " ",
    "\x00",
    "\ud800",
    "\udfff\ud800",
    "\ufffe\uffff",
    "\U0010ffff",
    "%s%n%x",
    "{0.__class__}",
    "$(reboot)",
    "../../../etc/passwd",
    "tense; tense",
    "tense\ntense",
    "tense\rhey robot",
    "\x1b[2Jtense",
    "None",
    "1e309",
)

STOPS = (
    "stop",
    "Stop",
    "STOP",
    "  stop  ",
    "\tstop\r\n",
    "stop.",
    "Stop!",
    "stop!!!",
    '"stop"',
    "...stop",
    "stop stop",
    "Stop. Stop, stop!",
    "stop\x00",
    "stop\u200b",
    "\ufeffstop",
    "\u202estop",
    "\u3000stop\u00a0",
    "stop" + " " * 10_000,
    "stop " * 10_000,
)

NO_STOPS = (
    "don't stop",
    "not stop",
    "stopp",
    "stops",
    "stop it",
    "s top",
    "st\u200bop",
    "\u0455top",
    "stop".translate(WIDE),
    "stop".translate(BOLD),
    "\u017ftop",
    "pit stop",
    "stop" * 100,
)
