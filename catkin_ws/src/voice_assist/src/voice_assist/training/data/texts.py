# SPDX-License-Identifier: BSD-3-Clause
"""What the synthetic voices say: commands, near misses, theatre talk, words."""

from __future__ import annotations

from collections.abc import Sequence
from random import Random

from voice_assist.recognizer.vocabulary import CHARACTERS
from voice_assist.text.amounts import UNITS, spoken_amount, spoken_value


def phrases(lines: str) -> tuple[str, ...]:
    """Phrases of lines of text, with "|" between them."""
    return tuple(lines.strip().replace("\n", "|").split("|"))


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
NEAR_MISSES = phrases("""
tents|dense|tens|ten|tennis|sense|pence|fence|hence|tent|attend|intense|tension
pretense|the tents are here|tense up|tensing|tend|test|tenth|guess|text|tells
least|lease|at least|police|release form|the release form|released|releasing|relief
leash|believe|really|reel|relax|relay|increase|please|peace|a lease|relapse
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
""")

# More of the same, for training alone: near misses that earlier checkpoints took for
# commands, negations, and commands inside sentences.
HARD = phrases("""
stops|stops it|it stops|stop sign|stop watch|stopper|stopwatch|stepped|stopping it|stock up
up|go|down|on|off|no|get up|sit down|go up|go down|go on|come on|turn it off|start it
start|started|starts|starting|start up|restart|start now|start over|smart|art|part|dark
stork|stalk|stark|storm|store it|spa|spots|stuck|stub|stubs|stump|tub|top up|up top|hop up
pool more|pool less|pull moors|pull mores|pull moore|full less|full more|fool more|pull morse
and less|and more|in less|for less|for more|bull less|pulls less|pulls more
pull the lens|pull a lesson|pull us|pull let's|pull left|pull list|pull last|pull lessons
pull morning|pull monitor|pull mortar|polar|poll more|paul moore|pulmonary|pull next|pull mess
tents|two tents|tenths|tens of them|tense is|tends|tenses|pens|then|sends|dents|lens|the lens
terminates|terminating|terminals|termite|terminus|turn it|turn it on|turning|turn mine eight
eliminate|nominate|dominate|laminate|contaminate|germinates|animate|ultimate|term in eight
releases|rely|relieve|received|recess|relish|relics|really this|believes|please
early|earlier peace|real ease|her lease|the lease|we lease|niece|geese|crease|decrease|leased
a rowboat|hey roman|hey row|hey roger|hey rowan|play robot|they robot|my robot|this robot
hey robotics|hey ron|hey robbie|hello|hey joe|hey john|hey siri|hey buddy|hey everyone|hey now
don't stop now|please don't stop|do not stop yet|never stop|you must not stop|we can't stop
do not pull|don't pull|do not pull any more|don't pull any more|please don't pull more
don't pull less now|you should not pull less|never pull less|don't ever pull more
never release|don't release it|do not release yet|please do not release|not release
do not tense up|don't be tense|never tense|not tense|do not terminate|never terminate
please do not terminate|not terminate|don't say stop|no stop signs|not stop|not pull more
i said pull it|i will pull more later|we pull more than we push|they pull less than before
if you pull more it tears|when they pull less it slips|who will release it|press release
news release|release date|time release|slow release|the release valve|release notes please
will it stop here|where does the bus stop|it will stop soon|a full stop|one stop shop|pit stop
stop and go|stop or go|stop looking|stop talking|stop worrying|stop at the door|stop the timer
past tense|future tense|the tense is wrong|a tense moment|so tense|very tense|tense and tired
terminate the call|terminate his contract|terminate it|to terminate|could terminate
a robot arm|the robot is here|robot vacuum|that robot|say hey robot|hey the robot moved
""")

# Of both, those a sound or two away from a command, which are most often taken for it.
TWINS = phrases("""
tents|dense|tens|ten|sense|pence|fence|hence|tent|tenth|tenths|tend|tends|dents|pens|tense up
least|lease|leash|leased|a lease|her lease|we lease|the lease|relief|relieve|relish|releases
full more|poor more|wool more|bull more|pool more|fool more|poll more|paul moore|pull moor
pull moors|push more|four more|pulls more|no more|pull mall|pull mortar
full less|pool less|bull less|pull left|pull us|pull list|pull last|push less|pulls less|no less
shop|top|stops|stopped|step|stuff|stock|stomp|chop|up|terminal|terminates|germinate|determinate
""")

# What begins like a command and goes on as another word, or has its vowels, for the lesson
# "beginnings". Words of the people's clips that measure are not among them.
BEGINNINGS = phrases("""
snow|snowing|snowman|snowball|snack|snail|snake|snap|sneeze|sniff|snore|slow|slowly|slope|sleep
smoke|small|smell|smile|so|sew|sock|sole|soul|soap|sobbing|spoke|spoon|spot on|spoil|spring|spar
stone|stove|stole|stony|stairs|steel|stitch|stocking|stomach|stocks|story|stars|storage|scold
scott|scan|scar|score|scope it|scalp|skin|school|sky|swan|swallow|show|shown|shock|shot|shots
joking|jump|jaw|job|joy|john|toe|toy|tow|taught|talk|toss|topic|tonic|told|those|though|don
few less|few glasses|a few less|new glass|blue glass|full glass|the glass|grass|glasses|class
pure glass|pull glass|view less|view this|view list|viewless|through less|you less|you guess
few more|view more|new more|you more|blue more|who's more|fuel more|cool more|pure more|to more
realise|re lease|the leaf|relic|breeze|release her|fleece|grease|trellis|travel less|jealous
tension rod|tents and|ten so|ten sir|dance|tanned|turns|chance|attends|ten cents|tin|tins|thins
""")

TALK = phrases("""
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
""")

DIGITS = (
    *("zero", "one", "two", "three", "four", "five", "six", "seven"),
    *("eight", "nine", "ten", "eleven", "twelve", "twenty", "thirty", "forty"),
    *("fifty", "sixty", "seventy", "eighty", "ninety", "hundred"),
)

_WAYS = ("more", "less")
_OTHER_UNITS = ("centimetre", "centimetres", "metre", "metres", "inches", "percent", "degrees")
# Commands with an amount, in and out of what any configuration takes, and amounts alone.
_VALUES = (0.2, 0.5, *range(1, 11), 1.2, 1.5, 2.5, 12, 15, 20, 30, 100)
_SAID = tuple(spoken_amount(value, unit) for unit in UNITS for value in _VALUES)
AMOUNTS = (
    *(f"{before}{amount} {way}" for amount in _SAID for before in ("pull ", "") for way in _WAYS),
    *(f"tension {amount}" for amount in _SAID),
    *(f"tension {spoken_value(value)}" for value in _VALUES),
    *(f"pull {number} {unit} more" for number in ("one", "two") for unit in _OTHER_UNITS),
    *_SAID,
)

_FILLED = ("um {}", "uh {}", "{} please", "please {}", "okay {}", "now {}", "{} now")


def normalise_text(text: str) -> str:
    """Lower-case letters, apostrophes inside words and single spaces only."""
    kept = "".join(c if c in CHARACTERS else " " for c in text.lower())
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
