# SPDX-License-Identifier: BSD-3-Clause
"""`make demo`: a spoken session moves the simulated robot, is checked, recorded and reported."""

from __future__ import annotations

import argparse
import datetime
import subprocess
import sys
import time
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import NoReturn

import rospy
import soundfile
from rich.console import Console
from rich.table import Table

from demo.check import StepVerdict, verdicts, worst_rcm_error
from demo.film import Camera, take_picture, write_film
from demo.page import PagePictures
from demo.script import VOICES, Script, load_script
from demo.sound import render
from demo.theatre import Hands, settings, start_devices
from demo.timeline import Timeline
from demo.virtual_microphone import VirtualMicrophone
from rst_control.simulation.rendering.window import window_obstacle
from support.interrupt import end_as_by_ctrl_c
from support.launched_system import System
from support.machine import hearing_obstacle
from support.process_groups import end_group
from support.theatre_sound import RATE
from typed_config import ConfigError, newest_recording, numbered_recordings

ROOT = Path(__file__).resolve().parent.parent
SCRIPTS = {  # of each way in which the simulated robot is led
    "fast": ROOT / "demo" / "session.yaml",
    "kinova_strict": ROOT / "demo" / "kinova_session.yaml",
}
SOUND_TIME = 20.0  # [s] allowed for the first sound to be heard
LISTEN_TIME = 20.0  # [s] allowed for the voice node to say that it listens
WAV_LEAD = 12.0  # [s] of noise before the script where the voice node plays the file itself
PAGE_AFTER = 1.5  # [s] after the beginning of a step that the page is photographed
ANNOUNCED = {
    "surgeon": 'surgeon says "{}"',
    "people": 'people  says "{}"',
    "pedal": 'a foot presses the pedal for "{}"',
    "hand": 'by hand, to the service: "{}"',
}
TAIL = 2.0  # [s] recorded after the last step


def main(argv: Sequence[str] | None = None) -> int:
    """Run the demonstration; returns the exit status: 0 when every step happened."""
    options = _parse(argv)
    console = Console()
    if options.gui and (obstacle := window_obstacle()):
        console.print(f"[red]The demo could not run:[/red] {obstacle}")
        return 1
    try:
        script = load_script(options.script or SCRIPTS[options.robot])
    except ConfigError as error:
        console.print(str(error), style="red", highlight=False, markup=False)
        return 2
    folder = options.out or ROOT / "sessions" / datetime.datetime.now().strftime(
        "%Y-%m-%d_%H-%M-%S"
    )
    folder = folder.resolve()
    try:
        folder.mkdir(parents=True, exist_ok=True)
        is_used = bool(numbered_recordings(folder))
    except OSError as error:
        words = f"The folder of the session cannot be made: {error.filename}: {error.strerror}"
        console.print(words, style="red", highlight=False, markup=False)
        return 2
    if is_used:
        words = f"{folder} holds a recording: name a new folder"
        console.print(words, style="red", highlight=False, markup=False)
        return 2
    try:
        results = _session(script, folder, options, console)
    except KeyboardInterrupt:
        console.print("\nInterrupted: the session so far is in", str(folder))
        _report(folder, console)
        return 130
    except (OSError, RuntimeError, rospy.ROSException) as error:
        console.print(f"[red]The demo could not run:[/red] {error}")
        console.print(f"What the nodes said is in {folder / 'launch.log'}")
        return 1
    made = {"session.mcap": newest_recording(folder) is not None}
    made["report.html"] = _report(folder, console)
    if options.film:
        made["film.gif"] = _film(folder, console)
    return _conclude(results, made, console)


def _parse(argv: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="make demo", description=__doc__)
    parser.add_argument("--script", type=Path, help="what is said, and when")
    parser.add_argument("--out", type=Path, help="folder of the session (sessions/<time>)")
    parser.add_argument("--gui", action="store_true", help="open the simulator's window")
    parser.add_argument("--microphone", action="store_true", help="listen to you, until Ctrl-C")
    parser.add_argument("--film", action="store_true", help="film the scene to film.gif")
    parser.add_argument(
        "--robot",
        choices=tuple(SCRIPTS),
        default="fast",
        help="how the simulated robot is led: by set-points, or as Kinova's own driver is",
    )
    parser.add_argument("--wav", action="store_true", help="do not try a virtual microphone")
    options = parser.parse_args(argv)
    if options.microphone and (options.wav or options.film):
        parser.error("--microphone is not allowed with --wav or --film")
    return options


def _session(
    script: Script, folder: Path, options: argparse.Namespace, console: Console
) -> list[StepVerdict]:
    """Bring the system up, play the script into it and judge what came of it."""
    with ExitStack() as stack:
        microphone = None if options.microphone or options.wav else _virtual(stack, console)
        lead = 0.0 if microphone else WAV_LEAD
        wav = folder / "script.wav"
        if not options.microphone:
            soundfile.write(wav, render(script, lead), RATE, subtype="PCM_16")
        source: dict[str, str | bool | Path]
        if options.microphone:
            source = {"source": "microphone"}
        elif microphone:
            source = {"source": "microphone", "device": microphone.device}
        else:
            source = {"source": "wav", "wav": wav}
        if slow := hearing_obstacle():
            console.print(f"[yellow]Steps may fail:[/yellow] {slow}")
        console.print(f"Starting the system (log: {folder / 'launch.log'})")
        source |= {"display": True, "display_port": "0"}  # any that is free
        if script.has_devices:
            source |= settings(folder)
        environment = microphone.environment if microphone else {}
        system = stack.enter_context(System(folder / "launch.log", environment))
        rospy.init_node("demo", anonymous=True, disable_signals=True)
        if options.robot == "kinova_strict":
            system.launch_kinova(folder, gui=options.gui, **source)
            system.home_tool()
        else:
            system.launch_session(folder, gui=options.gui, **source)
        timeline = stack.enter_context(Timeline(console))
        page, hands = PagePictures(folder, timeline.say), Hands(timeline.warn)
        stack.callback(page.close)
        page.start()  # with the system: what starts later takes a core from those who hear
        if script.has_devices:
            stack.callback(end_group, start_devices())
        _wait_until_ready(system, timeline)
        page.wait_for_browser()
        if options.microphone:
            _listen(system, timeline)
        with timeline.first_sound(SOUND_TIME, is_file=microphone is None) as first_sound:
            if microphone:
                timeline.listening.wait(LISTEN_TIME)  # where it never does, the checks show it
                player = microphone.play(wav)
                stack.callback(player.terminate)
            timeline.start_clock(first_sound() + lead)
        if options.film:
            stack.callback(Camera(timeline.warn).close)
        _follow(script, system, timeline, page, hands)
        worst = worst_rcm_error(timeline.observed)
        timeline.say(f"the controller's largest RCM error in the patient: {worst * 1e6:.2g} um")
        return verdicts(script, timeline.observed)


def _virtual(stack: ExitStack, console: Console) -> VirtualMicrophone | None:
    try:
        return stack.enter_context(VirtualMicrophone())
    except OSError as error:
        console.print(f"No virtual microphone ({error}): the voice node reads the sound file.")
        return None


def _wait_until_ready(system: System, timeline: Timeline) -> None:
    parts = {
        "recorder": timeline.recorder_ready,
        "robot": timeline.controller_ready,
        "voice": timeline.voice_ready,
    }
    system.wait_for(parts, lambda part: timeline.say(f"{part} ready", "green"))


def _follow(
    script: Script, system: System, timeline: Timeline, page: PagePictures, hands: Hands
) -> None:
    """Announce each step as it is spoken; take a picture at its end, some of them of the page."""
    take_picture(timeline.warn)
    for i, step in enumerate(script.steps):
        _wait_until(step.at, system, timeline)
        if step.speaker in VOICES:
            timeline.intend("" if step.effect == "nothing" else step.say)
        timeline.say(ANNOUNCED[step.speaker].format(step.say), "bold white")
        hands.act(step)
        end = script.end_of(i)
        if step.moment:
            _wait_until(step.at + PAGE_AFTER, system, timeline)
            page.take(step.moment)
        if step.effect in ("tense", "more", "less", "stopped", "released"):
            _wait_until(end - 1.0, system, timeline)
            take_picture(timeline.warn)
        _wait_until(end, system, timeline)
    time.sleep(TAIL)


def _wait_until(moment: float, system: System, timeline: Timeline) -> None:
    while timeline.now() < moment:
        if not system.is_running():
            raise RuntimeError("a part of the system ended during the session")
        time.sleep(min(0.05, max(moment - timeline.now(), 0.0)))


def _listen(system: System, timeline: Timeline) -> NoReturn:
    timeline.say('Listening to you: say "hey robot", then "tense". Ctrl-C ends the session.')
    while system.is_running():
        time.sleep(0.2)
    raise RuntimeError("a part of the system ended during the session")


def _report(folder: Path, console: Console) -> bool:
    """Make the report of the recording by the same command that a user has; whether it is made."""
    command = [sys.executable, "-m", "session_log.cli", "report", str(folder)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        console.print(f"[red]No report:[/red] {done.stderr.strip() or done.stdout.strip()}")
    else:
        console.print(f"Session, recording and report: {folder}")
    return done.returncode == 0


def _film(folder: Path, console: Console) -> bool:
    """Make the film of the newest recording; whether it is made."""
    recording, name = newest_recording(folder), folder / "film.gif"
    pictures = write_film(recording, name) if recording else 0
    why = f"only {pictures} were drawn: the machine was too busy with other work"
    console.print(f"{pictures} pictures in {name}" if pictures > 1 else f"No {name}: {why}")
    return pictures > 1


def _conclude(results: Sequence[StepVerdict], made: Mapping[str, bool], console: Console) -> int:
    table = Table(title="What the script asked for")
    for column in ("said", "effect", "happened", "seen"):
        table.add_column(column)
    for verdict in results:
        mark = "[green]yes[/green]" if verdict.happened else "[red]no[/red]"
        table.add_row(verdict.step.say, verdict.step.effect, mark, verdict.found)
    console.print(table)
    missed = [v.step.say for v in results if not v.happened]
    missed += [name for name, is_made in made.items() if not is_made]
    if missed:
        console.print(f"[red]Did not happen:[/red] {', '.join(missed)}")
    return 1 if missed else 0


if __name__ == "__main__":
    end_as_by_ctrl_c()
    sys.exit(main())
