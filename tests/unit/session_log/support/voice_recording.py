# SPDX-License-Identifier: BSD-3-Clause
"""Recordings of what was heard and decided, and what a pipeline decides now."""

import yaml

from session_log.mcap_file.writer import SessionWriter
from support.story import START, Story, numbered
from tests.unit.session_log.support.fake_pipeline import utterance

BLOCK = 512
ZERO = START * 1e-9  # [s] of the clock
FACTS = {"model": "embedded", "model_sha256": "ab" * 32, "spotter_sha256": ""}
SETTINGS = {"recognizer": {"model": "embedded"}}
ACTIVE = {"mode": "active", "reason": "hey robot"}


def say(story, end, **changes):
    """A recorded utterance that ended at a time of the session [s]."""
    u = utterance(end, **changes)
    fields = {
        name: getattr(u, name) for name in ("transcript", "command", "reason", "nearest_command")
    }
    fields |= {
        name: getattr(u, name) for name in ("confidence", "mode", "decided_by", "is_partial")
    }
    fields |= {n: float(getattr(u, n)) for n in ("speech_start", "speech_end", "decision")}
    wer = {"phrases": list(u.wer), "wer": list(u.wer.values())}
    topic = "/voice_assist/utterance"
    story.say(u.decision + 0.01, topic, "voice_assist/Utterance", **fields, **wer)


def hears(end, **changes):
    """What the pipeline decides now about speech that ended at a time of the session [s]."""
    return utterance(ZERO + end, **changes)


def say_sound(story, time, first, value=1, rate=16_000, count=BLOCK):
    """A block of sound from a sample on, of this value throughout."""
    fields = {"rate": rate, "first_sample": first, "samples": [value] * count}
    story.say(time, "/voice_assist/audio", "voice_assist/AudioChunk", **fields)


def play(story, begin, end, start=0.0, skip=()):
    """Sound of a run of the node that began at `start`; blocks of the session's time [s]."""
    for first in range(round(begin * 16_000) // BLOCK * BLOCK, round(end * 16_000), BLOCK):
        if first not in skip:
            say_sound(story, start + first / 16_000, first)


def note(story, time, text):
    story.say(time, "/voice_assist/circumstances", "std_msgs/String", data=text)


def write(path, story, facts=FACTS, lost=(0.0, 0.0)):
    """Write a session; what was said from the one time to the other is lost from the file [s]."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with SessionWriter(path) as writer:
        writer.add_metadata("session/voice_assist", facts)
        writer.add_metadata("parameters", {"voice_assist": yaml.safe_dump(SETTINGS)})
        ordered = numbered(sorted(story.messages, key=lambda m: m.log_time))
        for message in ordered:
            if not lost[0] <= (message.log_time - START) * 1e-9 < lost[1]:
                writer.add(message)
                writer.commit()
    return path


def block(time):
    """First sample of the block at a time [s]."""
    return round(time * 16_000) // BLOCK * BLOCK


def ordinary(path, **options):
    """Ten seconds, in which "tense" was said twice."""
    story = Story()
    play(story, 0.0, 10.0)
    say(story, 3.0)
    say(story, 6.0)
    return write(path, story, **options)


SAME = {block(3.2): [hears(3.0)], block(6.2): [hears(6.0)]}
