# SPDX-License-Identifier: BSD-3-Clause
"""What each cause asks a person to do: tables of words, complete over all that is known.

Causes arrive as the words that the controller, the recogniser or a health report chose for people.
A pattern finds the entry; the first that fits counts. `UNKNOWN` is for words that nobody foresaw:
test_alarm_causes.py shows that none of the controller's is among them.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final

from voice_assist.alarms.types import Kind


@dataclass(frozen=True)
class Cause:
    """A cause that is known by its words."""

    name: str  # of refusals by verification the value of the controller's `Reason`
    pattern: str  # regular expression, searched in the words
    next_step: str  # short, in the imperative
    kind: Kind = Kind.FAULT

    def fits(self, words: str) -> bool:
        """Whether the words tell of this cause."""
        return re.search(self.pattern, words) is not None


UNKNOWN: Final = Cause("unknown", "", 'Look at the robot; say "hey robot" once it is safe.')
NO_REASON: Final = Cause("no reason", "", "Read the reason, then say it again.", Kind.REFUSAL)

_ON: Final = 'then say "hey robot"'


def _stop(name: str, pattern: str, next_step: str) -> Cause:
    return Cause(name, pattern, next_step, Kind.STOP)


def _refusal(name: str, pattern: str, next_step: str) -> Cause:
    return Cause(name, pattern, next_step, Kind.REFUSAL)


LATCHES: Final = (  # of ControllerState.halt_reason: what braked and latched
    _stop("stop by topic", "^stop topic, from", 'Say "hey robot" when it is safe to go on.'),
    _stop("stop by command", '^"stop" from', 'Say "hey robot" when it is safe to go on.'),
    _stop(
        "stop by cancel",
        "^stop by cancelling ",
        'Say "hey robot" when it is safe to go on.',
    ),
    _stop(
        "shutdown",
        "^the controller is being shut down",
        "Start the controller again before the next command.",
    ),
    Cause("not recorded", "^not recorded", f"Start the recorder, {_ON}."),
    Cause(
        "not connected",
        "^robot not connected",
        f"Check the robot's power, cable and driver, {_ON}.",
    ),
    Cause("no master", "^the ROS master ", f"Start the ROS master again, {_ON}."),
    Cause(
        "node lost",
        "during its motion$",
        f"Start the node that is named again, {_ON}.",
    ),
    Cause("stale", "^joint states stale", f"Check the robot's driver and its network, {_ON}."),
    Cause(
        "set-points stopped",
        "^robot fault: set-points stopped",
        f"Check that the controller's machine keeps up, {_ON}.",
    ),
    Cause(
        "set-point refused",
        "^robot fault: .*(set-point|away from where it holds)",
        f"Check the joint that is named, {_ON}.",
    ),
    Cause("sensor fault", "^sensor fault: ", f"Check the sensor that is named, {_ON}."),
    Cause("tension sensor", "^robot fault: tension", f"Check the tension sensor, {_ON}."),
    Cause(
        "joint messages",
        "^robot fault: (joint states|the last .* refused)",
        f"Check the robot's driver, {_ON}.",
    ),
    Cause("robot fault", "^robot fault: ", f"Clear the fault at the robot, {_ON}."),
    Cause(
        "off its set-point",
        "rad off its set-point",
        f"Look what pushed or holds the arm and free it, {_ON}.",
    ),
    Cause(
        "off the trocar",
        "^shaft .* off the trocar",
        f"Look at the trocar; set it anew if it moved, {_ON}.",
    ),
    Cause("over tension", "^tension .* N.*, allowed", 'Say "hey robot", then "release".'),
    Cause("slipped", "^tissue slipped", 'Look at the tissue; say "hey robot", then "tense".'),
    Cause(
        "voice silent",
        "^voice node silent",
        "Check the microphone; give commands by hand meanwhile.",
    ),
    Cause("overtime", "^phase took", f"Look what holds the robot up, {_ON}."),
    Cause(
        "loop error",
        "^error in the control loop",
        "Free the tissue by hand; start the controller again.",
    ),
)

GIVE_UPS: Final = (  # of the diary's at_rest: a motion that could not reach its end; no latch
    Cause(
        "no answer to pull",
        "^tension rose by",
        'Look at tissue and jaws; say "release", then "tense".',
    ),
    Cause("closed on nothing", "^nothing grasped", 'Bring tissue to the jaws; say "tense" again.'),
    Cause(
        "caught tissue", "^the closing jaws caught tissue", 'Say "release", then give it once more.'
    ),
)
ENDED_AS_ASKED: Final = "terminated"  # the diary's at_rest after "terminate"

REFUSALS: Final = (  # of the diary's refused and trocar_refused
    _refusal("unknown command", "^unknown command", "Say one of the known commands."),
    _refusal("wrong mode", "^in standby;", 'Say "hey robot" first.'),
    _refusal(
        "halted", r"^(halted \(|stopped meanwhile)", 'Say "hey robot" when it is safe to go on.'
    ),
    _refusal("busy", "^busy", 'Wait until it rests, or say "stop".'),
    _refusal(
        "not at rest",
        "^(not at rest|still braking|braking|robot not at rest|moving;|stopping;)"
        "|begin .* away from where the robot stands",
        "Wait until it rests, then say it again.",
    ),
    _refusal("by hand only", "is given by hand, never by voice", "Give this command by hand."),
    _refusal("may not command", "may not give commands", "Let somebody who may give it."),
    _refusal("too many calls", "^too many calls from", "Wait a moment, then say it again."),
    _refusal("bad amounts", "^tension and distance must be", "Give numbers from 0 up."),
    _refusal("queue full", "commands are waiting already", "Wait for the answers, then repeat it."),
    _refusal("changing", "^the situation keeps changing", "Wait a moment, then say it again."),
    _refusal("check failed", "^error while checking", "Read the log; try another command."),
    _refusal("withdrawn", "^(stopped|said again)$", 'Say "hey robot" when you want to go on.'),
    _refusal("not recorded", "not recorded: ", "Start the recorder, then say it again."),
    _refusal("not connected", "^robot not connected", "Check the robot's power, cable and driver."),
    _refusal("not confirmed", "^dry run: ", "Look at the path that is shown, then confirm it."),
    _refusal("no master", "^the ROS master ", "Start the ROS master again."),
    _refusal("node lost", "^/.* (ended|was stopped|hung up)$", "Start the node that is named."),
    _refusal(
        "voice silent",
        "^voice node (silent|without)",
        "Check the microphone; give commands by hand meanwhile.",
    ),
    _refusal("sensor fault", "^sensor fault: ", "Check the sensor that is named."),
    _refusal("faulted", "^robot fault: ", "Clear the fault at the robot, then say it again."),
    _refusal("joint states stale", "^joint states", "Check the robot's driver and its network."),
    _refusal("already grasped", "^tissue (already grasped|held|is held)", 'Say "release" first.'),
    _refusal("already there", "^already (outside|inserted)", "Go on; nothing is left to do."),
    _refusal("nothing grasped", "^nothing grasped", 'Say "tense" first.'),
    _refusal("not inserted", "^tool not inserted", 'Give "insert" by hand first.'),
    _refusal(
        "tension limit",
        "tension would be|tension is .* already|^asked for ",
        'Pull no further; say "pull less" or "release".',
    ),
    _refusal(
        "displacement limit", "^pulled .* mm, allowed", 'Pull no further; "release" and regrasp.'
    ),
    _refusal(
        "no grasp", r"none of \d+ ways to take the tissue", "Move the grasp point, or the tissue."
    ),
    _refusal("collision", "mm from .*, allowed .* mm and more", "Make room round the arm."),
    _refusal("near singular", "manipulability", "Bring the arm into another pose first."),
    _refusal("workspace", "from the workspace centre", "Choose a point nearer to the middle."),
    _refusal("tilt limit", "from the patient's inward normal", "Look another way."),
    _refusal("insertion depth", "of shaft inserted", 'Give "insert" by hand first.'),
    _refusal("joint limit", "at .* rad, allowed", "Bring the arm into another pose first."),
    _refusal("rcm tolerance", "off the trocar", "Bring shaft and trocar together; set it anew."),
    _refusal("not the trocar", "off it, allowed", "Bring the shaft into the trocar, then set it."),
    _refusal(
        "unreachable",
        "^cannot |unreachable|out of|reach",
        "Choose a point that is easier to reach.",
    ),
)

UNHEARD: Final = (  # of Utterance.reason: the words of a command were heard, and it was not taken
    _refusal("unsure", "^confidence ", "Say it again, clearly."),
    _refusal("sounds like another", "^it sounds more like", "Say it again, clearly."),
    _refusal("halt unsure", "^the recogniser is not sure", 'Say "stop" again, or stop by hand.'),
    _refusal(
        "other voice",
        "^not this voice|too short to tell the voice|^the speaker gate",
        "Let the enrolled person say it, or give it by hand.",
    ),
    _refusal("damaged sound", "^damaged sound", "Check the microphone and its cable."),
    _refusal("tone", "^a tone, no voice", "Say it again, or give it by hand."),
    _refusal("robot speaking", "^the robot itself was", "Wait until it has spoken, then repeat."),
    _refusal("same breath", "in the same breath", "Pause, then say the command alone."),
    _refusal("wrong mode", "counts only in active mode", 'Say "hey robot" first.'),
    _refusal("other mode", "counts only in", "Wait for the other mode, then say it again."),
)

PARTS: Final = (  # of a part's name and what it says: health reports with an error, and silence
    Cause(
        "voice spotter",
        "voice: spotter",
        "Speak clearly; start the voice node again at the next pause.",
    ),
    Cause(
        "voice starting",
        "voice: no sound has come yet",
        "Stop by hand meanwhile; look at the microphone if it lasts.",
    ),
    Cause(
        "voice slow",
        "voice: recognition does not keep up",
        "Stop by hand meanwhile; close other programs.",
    ),
    Cause(
        "voice hangs",
        "voice: recognition hangs",
        "Stop by hand meanwhile; start the voice node again.",
    ),
    Cause(
        "voice gone", "voice: no word for", "Stop by hand meanwhile; start the voice node again."
    ),
    Cause(
        "voice muted",
        "voice: the microphone gives one value",
        "Stop by hand meanwhile; switch the microphone on.",
    ),
    Cause(
        "voice overloaded",
        "voice: the microphone is overloaded",
        "Stop by hand meanwhile; turn noise or gain down.",
    ),
    Cause("voice deaf", "voice: ", "Stop by hand meanwhile; check the microphone."),
    Cause(
        "controller gone",
        "controller: no word for",
        "Free the tissue by hand; start the controller again.",
    ),
    Cause("recorder lost", "recording: ", "Start the recorder before the next motion."),
    Cause(
        "controller thread", "control loop: ", "Read the log; restart the controller at a pause."
    ),
    Cause("master gone", "motion: the ROS master", "Start the ROS master again."),
    Cause("robot unwell", "motion: ", "Check the robot's power, cable and driver."),
)


def find(table: Iterable[Cause], words: str, otherwise: Cause) -> Cause:
    """The first entry that fits the words; `otherwise` where none does."""
    return next((cause for cause in table if cause.fits(words)), otherwise)
