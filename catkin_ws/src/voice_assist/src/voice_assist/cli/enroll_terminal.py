# SPDX-License-Identifier: BSD-3-Clause
"""The guided recording in the terminal: a phrase, a level meter, and whether the take was good."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from rich.console import Console
from rich.live import Live
from rich.text import Text

from voice_assist.audio.source import AudioSource
from voice_assist.cli.level_meter import level_bar
from voice_assist.enrolment.takes.checks import Checked
from voice_assist.enrolment.takes.recording import record
from voice_assist.enrolment.takes.script import EnrolmentScript, EnrolmentStep
from voice_assist.profile.manifest import COMMAND, ROOM
from voice_assist.types import Frame, Samples

Ready = Callable[[EnrolmentStep], object]  # waits until the person is ready


def guide(script: EnrolmentScript, source: AudioSource, console: Console, ready: Ready) -> None:
    """Record all that is missing.

    Each take is kept the moment it is good, so that it may be broken off and gone on with. The
    microphone is open only while a take is recorded.

    Args:
        script: Of the profile.
        source: Of the sound, opened anew for each take; of a microphone the same one each time.
        console: Where it is shown.
        ready: Waits for the person before each take.

    Raises:
        VoiceError: The source or the profile failed.
    """
    while (step := script.next()) is not None:
        console.print(_asked(step))
        ready(step)
        samples = _record(source, step, console)
        console.print(result_line(step, script.offer(step, samples)))


def _record(source: AudioSource, step: EnrolmentStep, console: Console) -> Samples:
    with source, Live(console=console, refresh_per_second=12, transient=True) as live:
        frames: Iterator[Frame] = iter(source)
        next(frames, None)  # the first one may hold the click of the microphone

        def show(level: float, done: float) -> None:
            live.update(Text.assemble(*level_bar(level), f" {done:4.0%}"))

        return record(frames, step.seconds, show)


def result_line(step: EnrolmentStep, checked: Checked) -> Text:
    """What came of a take, in a line."""
    if checked.is_good:
        what = f"good: {checked.level_db:.0f} dB, {checked.snr_db:.0f} dB over the room"
        heard = f", heard as {checked.heard!r}" if step.kind == COMMAND else ""
        return Text(f"  {what if step.kind != ROOM else 'good'}{heard}", style="green")
    again = "once more, please" if not checked.is_unlike else "if that is how you say it, again"
    return Text(f"  {'; '.join(checked.problems)}; {again}", style="yellow")


def _asked(step: EnrolmentStep) -> Text:
    number = f"{step.number} of {step.total}"
    if step.kind == COMMAND:
        return Text.assemble(f"{number}: say  ", (step.phrase, "bold cyan"))
    if step.kind == ROOM:
        return Text(f"{number}: the room, {step.seconds:.0f} s; nobody speaks")
    return Text(
        f"{number}: talk freely for {step.seconds:.0f} s, as you do at work, and say no command"
    )
