# SPDX-License-Identifier: BSD-3-Clause
"""Adds a voiceprint to a profile, from the takes that it holds."""

from __future__ import annotations

from voice_assist.config.speaker import SpeakerConfig
from voice_assist.profile.manifest import COMMAND, TALK
from voice_assist.profile.profile import VoiceProfile
from voice_assist.speaker.cohort import read_cohort
from voice_assist.speaker.network import VoiceNetwork
from voice_assist.speaker.voiceprint import FILE, Voiceprint, make_voiceprint


def put_voiceprint(profile: VoiceProfile, config: SpeakerConfig) -> Voiceprint:
    """Learn the voice of a profile and keep it there, in place of an older voiceprint.

    Raises:
        VoiceprintError: The takes are too few, or do not distinguish the voice from others.
        ModelError: The network or the background voices are missing.
        VoiceProfileError: A take cannot be read, or the voiceprint not be written.
    """
    said = [t for t in profile.manifest.takes if t.kind in (COMMAND, TALK)]
    cohort, digest = read_cohort()
    takes = [profile.sound(take) for take in said]
    voiceprint = make_voiceprint(takes, VoiceNetwork(), cohort, digest, config)
    profile.put(FILE, voiceprint.to_bytes())
    return voiceprint
