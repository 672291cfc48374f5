# SPDX-License-Identifier: BSD-3-Clause
"""What sounds like a command, denies one or speaks of one, and must move nothing."""

from __future__ import annotations

from itertools import cycle
from random import Random

from voice_assist.training.data import texts
from voice_assist.training.data.synthesis import plan_held_out
from voice_assist.training.data.voices import Prompt, by_voice

SOUNDS_LIKE = texts.phrases("""
tents|dense|least|full more|shop|stop pulling|the release form|terminal|ten|tens|tenth|tennis
sense|fence|hence|pence|tension|intense|pretense|tent|attend|test|guess|lens|tends|tensed
lease|at least|police|relief|believe|leash|release form|released|releasing|relax|relay|re lease
please|peace|increase|decrease|niece|the lease|bull more|poor more|wool more|pool more|fool more
full less|pool less|bull less|pull over|pull it|pull up|pull|more|less|pulling|push more|push less
more pull|less pull|pull moor|pull mall|paul moore|pull the lens|pull a lesson|pull left|pull last
step|top|drop|chop|stuff|stock|stopped|stopping|stops|start|strap|slop|stomp|on top|a step
bus stop|laptop|full stop sign|stop the music|stop the bleeding|terminated|termination|determine
turn eight|term|germinate|nominate|the terminal|eliminate|illuminate|robot|hey|hey robin|rowboat
hey rabbit|hey robert|a robot|the robot arm|hey doctor|hey rob it|hey roberta|robots
""")

DENIED = texts.phrases("""
don't stop|do not stop|never stop|please don't stop|you must not stop|we cannot stop now
don't pull more|do not pull more|never pull more|don't pull any more|please do not pull more
i said do not pull more|you should not pull more|we won't pull more|not pull more|no don't pull more
don't pull less|do not pull less|never pull less|you should not pull less|please don't pull less
we can't pull less|not pull less|don't you pull less
don't release|do not release|never release|please do not release|not release|don't release it
he did not say release|we cannot release yet|without release
don't tense|do not tense|never tense|not tense|please don't tense|do not tense it now
don't terminate|do not terminate|never terminate|please do not terminate|not terminate
i would not terminate|no more|no less|not more
""")

IN_A_SENTENCE = texts.phrases("""
then we pull more on the left side|if you pull more it tears|when they pull less it slips
i will pull more later|he would pull more than she does|we pull more gauze from the tray
can you ask him to pull less|they pull less than before|she said pull less hard next time
you pull more than you need|let us see whether to pull more or not|pull more gauze
who will release it|it should release now and then|the news release comes on monday
release the clamp|i signed the release form yesterday|a slow release of the drug
we release the patient tomorrow|release notes are on the desk|press release
a tense moment for all of us|he was tense before surgery|past tense of the verb
the tense muscles relax under anaesthesia|tense and tired after the shift|so tense today
they terminate the contract in may|we could terminate the call|terminate his shift at noon
does it terminate by itself|to terminate the program press the key|terminate the phone call
the robot is not moving|hey robot vacuum cleaner|that robot was expensive|say hey robot to it
we should stop for coffee later|stop by my office after lunch|where does the bus stop
why did it stop|will it stop here|stop worrying about that|the bleeding will stop soon
stop at the door please doctor|tell him to stop talking
""")

NAMED = texts.phrases("""
tents|dense|least|full more|shop|don't stop|stop pulling|don't pull more|the release form|terminal
""")

ALL = {"sounds like": SOUNDS_LIKE, "denied": DENIED, "in a sentence": IN_A_SENTENCE}
TRAINED = frozenset((*texts.NEAR_MISSES, *texts.HARD, *texts.TALK, *texts.COMMANDS))


def plan(seed: int, voices: int) -> list[Prompt]:
    """Each phrase by so many of the held-out voices, all voices in turn.

    Args:
        seed: Of the training run whose held-out voices speak.
        voices: Per phrase.

    Returns:
        Sorted by engine and voice, as synthesis wants them.
    """
    rng = Random(seed + 2)
    cast = sorted({(prompt.engine, prompt.voice) for prompt in plan_held_out(seed)})
    rng.shuffle(cast)
    turn = cycle(cast)
    prompts = []
    for text in (phrase for phrases in ALL.values() for phrase in phrases):
        for _ in range(voices):
            engine, voice = next(turn)
            rate, pitch = rng.uniform(0.85, 1.2), rng.uniform(0.35, 0.65)
            prompts.append(Prompt(text, engine, voice, rate, pitch))
    return sorted(prompts, key=by_voice)
