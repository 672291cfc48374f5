# SPDX-License-Identifier: BSD-3-Clause
"""Hours of talk in standby: nothing may move, whatever is taken for "hey robot" in between.

HOURS=30 for the record. Pieces that are there are counted, those of other machines too, so that it
can be done in several goes.
"""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from typing import Any

from bench.common import resumable
from bench.voice import outcomes
from bench.voice.hearing import pieces
from bench.voice.hearing.pieces import SceneRecord
from bench.voice.material.theatre_talk import SECONDS, TalkChunk, Who, deck
from bench.voice.no_commands.armed import length, of_commands
from bench.voice.outcomes import motions
from bench.voice.trials import STOP
from support.figures import Figure

WHO: tuple[Who, ...] = ("human", "synthetic")
FULL = 30.0  # [h]
HOURS = min(FULL, float(os.environ.get("HOURS", "0.2")))


def measure() -> list[Figure]:
    """People and synthetic voices in turn, counted apart."""
    plan = _plan()
    wanted = math.ceil(HOURS * 3600.0 / SECONDS)
    pieces.restore("unarmed")
    chosen = pieces.up_to("unarmed", plan, wanted)
    records = pieces.measured("unarmed", {"": chosen})[""]
    pieces.keep("unarmed", chosen)
    hours = sum(r.heard.streamed for r in records) / 3600.0
    figures = [resumable.measured(hours, "h", FULL)]
    said = {who: [r for r in records if r.label["who"] == who] for who in WHO}
    unique = {who: length(deck(who)) for who in WHO if said[who]}  # of clips, again and again
    figures += of_commands("talk, unarmed", records, 0.0, unique=sum(unique.values()))
    figures.append(_reaching(records))
    for who, clips in unique.items():
        figures += of_commands(f"{who} talk, unarmed", said[who], unique=clips)
        figures += _armed(who, said[who])
    compute = sum(r.heard.compute for r in records)
    figures.append(Figure("real-time factor on talk", compute / (3600.0 * hours), ""))
    data = {"fired": [one for r in records for one in fired(r)]}
    resumable.write_details("voice/unarmed_fired.json", hours, data)
    return figures


def fired(record: SceneRecord) -> list[dict[str, Any]]:
    """Every command taken in a piece, with the utterance that was last begun before it."""
    found = []
    for one in outcomes.fired([record], "who", "seed"):
        begun = pieces.begun_last(record.label["spans"], one["at"])
        _, text, voice, path = begun or (0.0, "", "", "")
        found.append({**one, "said": text, "voice": voice, "path": path})
    return found


def reaching(records: Sequence[SceneRecord]) -> int:
    """Motions taken while no "stop" is latched: what the robot would not refuse as halted.

    The controller latches every "stop", in standby too, and refuses all motion until the next
    "hey robot"; the voice mode stays as it is meanwhile.
    """
    count = 0
    for record in records:
        is_halted = False
        for command in record.heard.taken:
            if command in (*STOP, "hey robot"):
                is_halted = command in STOP
            count += command in motions() and not is_halted
    return count


def _reaching(records: Sequence[SceneRecord]) -> Figure:
    note = '(the others came after a "stop", which halts it until "hey robot")'
    return Figure("talk, unarmed: motions to a robot not halted", reaching(records), "", note=note)


def _plan() -> list[TalkChunk]:
    count = math.ceil(FULL * 3600.0 / SECONDS)
    has_people = bool(deck("human"))
    if not has_people:
        print("no human speech in ../shared/speech: synthetic talk alone")
    who = WHO if has_people else WHO[1:]
    return [TalkChunk(who[i % len(who)], i // len(who)) for i in range(count)]


def _armed(who: str, records: Sequence[SceneRecord]) -> list[Figure]:
    """How long a "hey robot" that nobody said has left it armed, until a piece was over."""
    hours = sum(r.heard.armed for r in records) / 3600.0
    note = "(until its piece of three minutes is over)"
    return [Figure(f"{who} talk: armed by mistake", hours, "h", note=note)]
