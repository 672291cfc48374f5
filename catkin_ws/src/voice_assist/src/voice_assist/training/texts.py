# SPDX-License-Identifier: BSD-3-Clause
"""What the synthetic voices say: commands, near misses, theatre talk, words."""

from __future__ import annotations

from collections.abc import Sequence
from random import Random

COMMANDS = (
    "hey robot",
    "tense",
    "release",
    "pull more",
    "pull less",
    "stop",
    "terminate",
)

# Said like a command, and no command: each must be written as what it is.
NEAR_MISSES = tuple(
    """
tents|dense|tens|ten|tennis|sense|pence|fence|hence|tent|attend|intense|tension
pretense|the tents are here|tense up|tensing|tend|test|tenth|guess|text|tells
least|lease|at least|police|release form|the release form|released|releasing|relief
leash|believe|really|reel|relax|relay|increase|please|peace|a lease|re lease|relapse
full more|pull|pull moor|full|more|less|pull mall|poor more|wool more|bull more
pull over|pull it|pull up|pull the other one|pull me|pull him less often|full less
pool less|pool more|pulling|pulled|push more|push less|push|more pull|less pull
shop|top|step|stuff|stock|stopped|stopping|stop pulling|stops|start|strap|chop|slop
drop|hop|pop|crop|stomp|star|store|stand|stay|still|stool|scope|sob|spot|stab|swap
the shop|on top|top it up|laptop|bus stop|a step|one step|next step|non stop
don't stop|do not stop|don't pull more|do not pull more|don't pull less|don't release
do not release|don't tense|never pull more|not more|no more|no less|don't terminate
terminal|terminated|termination|determine|determinate|term|the terminal|germinate
robot|hey|hey robin|hey rob|a robot|the robot|hay|hey bob|ok robot|hello robot|robots
hey there|hey robert|they rob it|hey you|rabbit|hey rabbit|robot arm|hey doctor
pull more gauze|pull less hard next time|stop the bleeding|stop the music
stop it now please|release the clamp|tense muscles|more light|less light|more or less
more suction|more traction|less tension|let go|hold|hold on|wait|go on|keep going
moor|mall|mole|pour|pore|core|four more|some more|any more|much more|once more
lesson|lest|loss|lass|let's|left|unless|useless|bless|dress|mess|yes|guess less
""".replace("\n", "|")
    .strip("|")
    .split("|")
)

TALK = tuple(
    """
can you pass me the scissors please|suction please|more light over here
where is the trocar|the patient is stable|blood pressure is one twenty over eighty
how was your weekend|we are almost done|please close the door|swab count is correct
what time is it|let me see the screen|turn the camera to the left|hold the camera still
there is some bleeding here|irrigation please|give me a bit more gas|next case at two
who is on call tonight|i need a new pair of gloves|could you move the table up
that looks good|very nice|thank you|be careful with the vessel|the clip is in place
clean the lens please|zoom in a little|zoom out|that is the bowel|what about lunch
call the recovery room|is the sample labelled|the music is too loud|turn it down
we should stop for coffee later|he told me to pull more shifts|release notes are out
the tension is high today|they terminate the contract in may|a robot vacuum at home
i could use less work|more or less the same|stop by my office later|pull the door shut
put the needle down|cut|coagulate|clamp|forceps|scalpel|gauze|retractor|stapler
open the window|good morning everyone|time out please|confirm the patient name
allergies none|antibiotics given|are we ready|start the timer|change the angle
slowly|gently|a little higher|a little lower|to the right|to the left|back|forward
up|down|yes|no|okay|right|sure|wait a second|one moment|what did you say|say it again
the robot is not moving|why did it stop|it should release now|i would pull it less
do you want more tea|she has less pain today|he was tense before surgery
the lease ends in june|the shop was closed|we camped in tents|dense tissue here
""".replace("\n", "|")
    .strip("|")
    .split("|")
)

DIGITS = (
    *("zero", "one", "two", "three", "four", "five", "six", "seven"),
    *("eight", "nine", "ten", "eleven", "twelve", "twenty", "thirty", "forty"),
    *("fifty", "sixty", "seventy", "eighty", "ninety", "hundred"),
)

_FILLED = ("um {}", "uh {}", "{} please", "please {}", "okay {}", "now {}", "{} now")

ALPHABET = " 'abcdefghijklmnopqrstuvwxyz"


def normalise_text(text: str) -> str:
    """Lower-case letters, apostrophes inside words and single spaces only."""
    kept = "".join(c if c in ALPHABET else " " for c in text.lower())
    words = (word.strip("'") for word in kept.split())
    return " ".join(word for word in words if word)


def command_variant(rng: Random) -> str:
    """A command said twice, with a filler, or two commands in a row."""
    first = rng.choice(COMMANDS)
    kind = rng.random()
    if kind < 0.5:
        return f"{first} {first}"
    if kind < 0.9:
        return rng.choice(_FILLED).format(first)
    return f"{first} {rng.choice(COMMANDS)}"


def number_phrase(rng: Random) -> str:
    """One to three number words."""
    return " ".join(rng.choices(DIGITS, k=rng.randint(1, 3)))


def word_span(sentences: Sequence[str], rng: Random, longest: int = 6) -> str:
    """Some consecutive words of a random sentence."""
    words = rng.choice(sentences).split()
    length = min(rng.randint(1, longest), len(words))
    start = rng.randint(0, len(words) - length)
    return " ".join(words[start : start + length])
