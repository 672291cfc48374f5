# SPDX-License-Identifier: BSD-3-Clause
"""The settings of the voice node, and what of its session outlives a crash."""

from __future__ import annotations

from dataclasses import asdict, replace
from typing import Final

import rospy

from typed_config import load_yaml
from typed_config.ros.launch_settings import is_restart, launch_settings
from voice_assist.audio.sound_file import check_sound
from voice_assist.config import (
    CONFIG_DIR,
    SECTIONS,
    KeptMicrophoneConfig,
    VoiceConfig,
    load_voice_config,
    voice_config,
)
from voice_assist.config.profile import ProfileConfig

OPENED: Final = "~opened_microphone"  # parameter: name of the one that was opened
PROFILE: Final = "~profile"  # parameter: the one in use
PRECISION: Final = "~precision"  # parameter: in which the recogniser computes, for a replay
HAS_GATE: Final = "~has_talk_gate"  # parameter: true once a pedal was heard that is the gate
OWN: Final = frozenset(  # of parameters that the node itself sets
    key.removeprefix("~") for key in (OPENED, PROFILE, PRECISION, HAS_GATE)
)
# Parameter beside the node's own, which are settings to a replay: SHA-256 of the profile in use, ""
# where the launch asked for it.
NOTED: Final = "noted_profile"


def node_settings() -> VoiceConfig:
    """The checked settings, with the microphone of the session in a node that crashed.

    Raises:
        ConfigError: They are not as they must be.
        AudioError: The recording that they name cannot be read to its end.
    """
    config = _as_before(_given())
    if config.audio.source == "wav":
        check_sound(config.audio.wav.path)
    return config


def keep_profile(profile: ProfileConfig, digest: str) -> None:
    """Note which profile is in use, so that a replay uses no other; name one that was changed.

    Args:
        profile: Of `node_settings`.
        digest: SHA-256 of what it hears with.
    """
    before = rospy.get_param(NOTED, "") if is_restart() else ""
    if before and digest != before:
        words = "profile %r was changed since it was loaded: %.12s is in use from now on, not %.12s"
        rospy.logerr(words, profile.name, digest, before)
    rospy.set_param(NOTED, "" if profile.sha256 else digest)  # first: PROFILE is no wish then
    rospy.set_param(PROFILE, asdict(replace(profile, sha256=digest)))


def _given() -> VoiceConfig:
    """From the node's private parameters; missing sections from the package's files."""
    kept = launch_settings(own=OWN, is_first=not is_restart())
    given = {name: kept[name] for name in SECTIONS if name in kept}
    if not given:
        rospy.loginfo("no private parameters; the settings are those of the package's files")
        return load_voice_config()
    files = {name: load_yaml(CONFIG_DIR / f"{name}.yaml") for name in SECTIONS if name not in given}
    return voice_config({**files, **given})


def _as_before(config: VoiceConfig) -> VoiceConfig:
    """With the microphone of the session, where the node was started again after a crash.

    Only the whole name counts, as it did before the crash: it may be a part of another's name.
    A profile may have been learned anew since, unless the launch asked for one by its SHA-256.
    """
    if not is_restart():
        return config
    if config.profile.sha256 == rospy.get_param(NOTED, ""):
        config = replace(config, profile=replace(config.profile, sha256=""))
    if not (opened := rospy.get_param(OPENED, "")):
        return config
    kept = {**vars(config.audio.microphone), "device": str(opened)}
    microphone = KeptMicrophoneConfig(**kept)
    return replace(config, audio=replace(config.audio, microphone=microphone))
