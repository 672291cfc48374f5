# SPDX-License-Identifier: BSD-3-Clause
"""Health of the voice node, as diagnostics at 1 Hz."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

import rospy
from diagnostic_msgs.msg import DiagnosticStatus
from diagnostic_updater import DiagnosticStatusWrapper, Updater

from voice_assist.types import HearingFault

_SMOOTHING = 0.02  # per frame: what is smoothed follows within about 2 s
CLIPPED = 0.01  # [share] of the sound at full scale from which it is worth a warning
SPOTTER_SLOW = "the spotter does not keep up; the recogniser alone hears a stop"
SLOW_FOR = 5.0  # [s] after the last frame that it never heard

# Each gap drops the word in progress: a "stop" and the pause after it must fit between two gaps.
# Ten synthetic ones were said to the real networks at moments spread between gaps of 32 ms. Every
# 0.3 s, none was taken; every 1.0 s, 6; from 1.5 s on, 9.
TORN_GAPS = 3  # gaps; two alone are a chance
TORN_WITHIN = 2.0  # [s] from the first to the last of them


@dataclass
class VoiceHealth:
    """What the threads of the node note down; single values, so no lock is needed."""

    model: str
    source: str
    capacity: int  # frames that fit the queue
    microphone: str = ""  # name of the open one; empty: none was opened yet
    trouble: str = "starting"  # with the source of sound
    trouble_fault: HearingFault = HearingFault.NO_SOUND
    remark: str = ""  # what a person should know of the sound; no trouble
    clocks: str = ""  # how the stamps of the sound differ from this host's clock
    failure: str = ""  # a thread ended by an error
    hang: str = ""  # recognition has been at one frame for too long
    slowest: float = 0.0  # [s] on one frame so far
    controller: str = ""  # what is wrong with the controller
    spotter: str = "off"  # model of the second way to a stop
    spotter_failure: str = ""  # its thread ended by an error
    spotter_dropped: int = 0  # frames that it never heard
    spotter_dropped_at: float = float("-inf")  # [s] clock time of the last
    level: float = -100.0  # [dB] of full scale
    clipped: float = 0.0  # [share] of the sound at full scale, smoothed
    sounded_at: float = float("inf")  # [s] steady clock, when the last frame came
    queued: int = 0  # frames
    dropped: int = 0  # frames
    lost: int = 0  # samples
    torn: str = ""  # what was wrong when gaps last came too often
    torn_at: float = float("-inf")  # [s] of the last gap of these
    gaps: tuple[float, ...] = ()  # [s] when the last TORN_GAPS of them were noticed
    real_time_factor: float = 0.0
    frame_done: float = float("-inf")  # [s] when the last frame was worked off
    behind: float = 0.0  # [s] of that frame then
    commanded: float = float("-inf")  # [s] when the last command was taken
    last_command: str = ""

    def note_trouble(self, trouble: str, fault: HearingFault = HearingFault.NO_SOUND) -> None:
        """Note what is wrong with the source, and log it once when it begins and ends."""
        before, self.trouble, self.trouble_fault = self.trouble, trouble, fault
        if trouble and trouble != before:
            rospy.logerr("%s", trouble)
        elif before and not trouble:
            rospy.loginfo("sound comes in")

    def note_microphone(self, name: str) -> None:
        """Note the microphone that is heard; what was remarked of another one is over."""
        if name != self.microphone:
            self.microphone, self.remark = name, ""

    def note_remark(self, words: str) -> None:
        """Note what a person should know of the sound, and log it once."""
        if words and words != self.remark:
            rospy.logwarn("%s", words)
        self.remark = words or self.remark

    def note_clocks(self, words: str) -> None:
        """Note how the stamps differ from this host's clock, and log when it begins and ends."""
        before, self.clocks = self.clocks, words
        if words and words != before:
            rospy.logerr("%s", words)
        elif before and not words:
            rospy.loginfo("the stamps of the sound are right again")

    def note_gap(self, samples: int, now: float, deaf_after: float) -> None:
        """Note a gap in the sound, and log it once when they come too often.

        Args:
            samples: That were lost.
            now: Clock time [s].
            deaf_after: Without a gap, after which a stop would be heard again [s].
        """
        was_torn = self.is_torn(now, deaf_after)
        self.lost += samples
        self.gaps = (*self.gaps, now)[-TORN_GAPS:]
        span = now - self.gaps[0]
        is_often = len(self.gaps) == TORN_GAPS and 0.0 <= span <= TORN_WITHIN
        if is_often and not was_torn:
            allowed = f"allowed {TORN_GAPS - 1} within {TORN_WITHIN:g} s"
            found = f"{TORN_GAPS} gaps within {span:.1f} s, {allowed}"
            self.torn = f"the sound is torn, {found}: a spoken stop is not heard"
            rospy.logerr("%s", self.torn)
        if is_often or was_torn:
            self.torn_at = now

    def note_spotter(self, dropped: int, now: float) -> None:
        """Note how many frames the spotter never heard, and log it once as it begins to lose them.

        Args:
            dropped: Of all frames so far.
            now: Clock time [s].
        """
        if dropped > self.spotter_dropped:
            if not self.is_spotter_slow(now):
                rospy.logerr("%s", SPOTTER_SLOW)
            self.spotter_dropped, self.spotter_dropped_at = dropped, now

    def sounded(self, level: float, clipped: float) -> None:
        """Note level [dB] and clipped share [0, 1] of one frame that has just come."""
        self.sounded_at = time.monotonic()
        self.level = level
        self.clipped += _SMOOTHING * (clipped - self.clipped)

    def worked(self, compute: float, duration: float) -> None:
        """Note the time spent on one frame [s]."""
        self.real_time_factor += _SMOOTHING * (compute / duration - self.real_time_factor)
        self.slowest = max(self.slowest, compute)

    @property
    def has_heard(self) -> bool:
        """Whether any sound has come yet."""
        return self.frame_done > float("-inf")

    def would_hear(self, now: float, deaf_after: float) -> bool:
        """Whether a spoken stop would be heard in time."""
        is_hearing = self.is_fresh(now, deaf_after) and not self.is_torn(now, deaf_after)
        return is_hearing and not (self.trouble or self.clocks or self.failure or self.hang)

    def is_fresh(self, now: float, deaf_after: float) -> bool:
        """Whether sound was worked off recently, and is stamped with about its time."""
        # a recording that is played faster is ahead of every clock
        apart = self.behind if self.source == "wav" else abs(self.behind)
        return now - self.frame_done < deaf_after and apart < deaf_after

    def is_spotter_slow(self, now: float) -> bool:
        """Whether the spotter recently lost sound, since it does not keep up."""
        return 0.0 <= now - self.spotter_dropped_at < SLOW_FOR

    def is_torn(self, now: float, deaf_after: float) -> bool:
        """Whether gaps came too often for a stop, and one came recently."""
        return 0.0 <= now - self.torn_at < deaf_after


class VoiceDiagnostics:
    """Publishes the health."""

    def __init__(self, health: VoiceHealth, clock: Callable[[], float], deaf_after: float) -> None:
        """Announce the node."""
        self._health, self._clock, self._deaf_after = health, clock, deaf_after
        self._updater = Updater()
        self._updater.setHardwareID(health.source)
        self._updater.add("voice", self._fill)

    def publish(self) -> None:
        """Publish once."""
        self._updater.force_update()

    def _fill(self, status: DiagnosticStatusWrapper) -> DiagnosticStatusWrapper:
        health, now = self._health, self._clock()
        level, message, fault = _summary(health, now, self._deaf_after)
        status.summary(level, message)
        status.add("reason_code", fault.value if fault else "")
        status.add("source", health.source)
        status.add("microphone", health.microphone or "none")
        status.add("model", health.model)
        status.add("spotter", health.spotter)
        status.add("spotter frames dropped", f"{health.spotter_dropped}")
        status.add("microphone level [dB]", f"{health.level:.1f}")
        status.add("clipped [%]", f"{100.0 * health.clipped:.1f}")
        status.add("queue [frames]", f"{health.queued}")
        status.add("frames dropped", f"{health.dropped}")
        status.add("samples lost", f"{health.lost}")
        status.add("real-time factor", f"{health.real_time_factor:.3f}")
        status.add("slowest frame [s]", f"{health.slowest:.3f}")
        status.add("behind the sound [s]", f"{health.behind:.3f}")
        status.add("last command", health.last_command or "none")
        age = now - health.commanded
        status.add("last command age [s]", f"{age:.1f}" if health.last_command else "never")
        return status


def _summary(
    health: VoiceHealth, now: float, deaf_after: float
) -> tuple[int, str, HearingFault | None]:
    error, warning = DiagnosticStatus.ERROR, DiagnosticStatus.WARN
    if health.failure:
        return error, health.failure, HearingFault.THREAD_ENDED
    if health.trouble:
        return error, health.trouble, health.trouble_fault
    if health.hang:
        return error, health.hang, HearingFault.HANGS
    if health.clocks:
        return error, health.clocks, HearingFault.CLOCKS
    if not health.has_heard:
        words = "no sound has come yet: a spoken stop is not heard"
        return error, words, HearingFault.NO_SOUND_YET
    if not health.is_fresh(now, deaf_after):
        return _stale(health, deaf_after)
    if health.is_torn(now, deaf_after):
        return error, health.torn, HearingFault.TORN
    if health.spotter_failure:
        return error, health.spotter_failure, HearingFault.SPOTTER_FAILED
    if health.is_spotter_slow(now):
        return error, SPOTTER_SLOW, HearingFault.SPOTTER_SLOW
    if health.controller:
        return warning, health.controller, None
    if health.queued > health.capacity // 2:
        return warning, "recognition falls behind", None
    if health.clipped >= CLIPPED:
        share = f"{health.clipped:.0%} of the sound, allowed below {CLIPPED:.0%}"
        return warning, f"the microphone clips {share}: turn its gain down", None
    if health.remark:
        return warning, health.remark, None
    return DiagnosticStatus.OK, "listening", None


def _stale(health: VoiceHealth, deaf_after: float) -> tuple[int, str, HearingFault | None]:
    if health.behind <= -deaf_after and health.source != "wav":
        ahead = f"the sound is stamped {-health.behind:.1f} s ahead, allowed {deaf_after:g} s"
        return DiagnosticStatus.ERROR, f"{ahead}: set the clocks", HearingFault.CLOCKS
    silent = time.monotonic() - health.sounded_at
    if silent >= deaf_after:
        words = f"no sound for {silent:.1f} s, allowed below {deaf_after:g} s"
        return DiagnosticStatus.ERROR, f"{words}: a spoken stop is not heard", HearingFault.NO_SOUND
    words = "recognition does not keep up: a spoken stop is not heard"
    return DiagnosticStatus.ERROR, words, HearingFault.SLOW
