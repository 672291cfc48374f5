# SPDX-License-Identifier: BSD-3-Clause
"""The profile that the settings name, put to use: weights, thresholds, the speaker's voiceprint."""

from __future__ import annotations

import copy
from dataclasses import replace
from typing import TYPE_CHECKING

from torch import Tensor

from voice_assist.config.commands import ENGLISH, CommandsConfig
from voice_assist.config.profile import ProfileConfig
from voice_assist.profile import model_file, spellings, thresholds
from voice_assist.profile.manifest import ACTIVE, RECORDING
from voice_assist.profile.profile import (
    VoiceProfile,
    VoiceProfileError,
    open_profile,
    profiles_folder,
)
from voice_assist.recognizer.embedded import EmbeddedRecognizer
from voice_assist.speaker.voiceprint import FILE

if TYPE_CHECKING:
    from voice_assist.config import VoiceConfig
    from voice_assist.recognizer.recognizer import Recognizer


def profile_in_use(config: ProfileConfig) -> VoiceProfile | None:
    """Open the profile; None: the base alone is asked for.

    Raises:
        ConfigError: No profile can have that name.
        VoiceProfileError: It is missing, damaged, not the one asked for, or not active; says why.
    """
    if not config.is_used:
        return None
    profile = open_profile(config.name, profiles_folder(config.folder))
    manifest, allowed = profile.manifest, "allowed: one that is active; or profile:=none"
    known = "", profile.digest, profile.manifest_digest  # the last is pinned in older recordings
    if config.sha256 not in known:
        found = f"has the SHA-256 {profile.digest[:12]}, allowed: {config.sha256[:12]}"
        raise VoiceProfileError(f"profile {profile.name!r} {found}; it was changed since")
    if manifest.state == RECORDING:
        words = f"voice_assist enroll {profile.name} finishes it"
        raise VoiceProfileError(f"profile {profile.name!r} is not finished, {allowed}; {words}")
    if manifest.state != ACTIVE:
        why = "; ".join(manifest.why)
        raise VoiceProfileError(f"profile {profile.name!r} failed its own check ({why}), {allowed}")
    profile.check()
    return profile


def _profile_of_language(config: VoiceConfig) -> VoiceProfile | None:
    """The profile in use; None: the base alone is asked for.

    Raises:
        VoiceProfileError: As `profile_in_use`, or it was not learned from a phrase of a language
            that the base does not know.
    """
    profile = profile_in_use(config.profile)
    if profile is not None and config.commands.language != ENGLISH:
        _require_learned(profile, config.commands)
    return profile


def _require_learned(profile: VoiceProfile, commands: CommandsConfig) -> None:
    learned = {take.phrase for take in profile.manifest.takes}
    if profile.has(thresholds.NAME):  # which names the phrases that were learned last
        newest = thresholds.from_bytes(profile.read(thresholds.NAME))
        learned &= {setting.phrase for setting in newest.commands}
    language = commands.language
    for phrase in commands.fixed_phrases:
        if phrase not in learned:
            found = f"was not learned from takes of {phrase!r}"
            allowed = f"allowed with language {language}: one enrolled in it; or profile:=none"
            again = (
                f"voice_assist --language {language} enroll {profile.name} records what it lacks"
            )
            raise VoiceProfileError(f"profile {profile.name!r} {found}, {allowed}; {again}")


def personalise(config: VoiceConfig, base: Recognizer) -> Recognizer:
    """The recogniser for the person that the settings name.

    Raises:
        VoiceProfileError: As `profile_in_use`, or the profile adapts another recogniser, or was not
            learned from every phrase of another language than English.
        ModelError: The adapted weights do not suit the recogniser.
    """
    profile = _profile_of_language(config)
    if profile is None:
        return base
    if profile.manifest.base_sha256 != base.model_hash:
        found = f"was made on top of the recogniser {profile.manifest.base_sha256[:12]}"
        allowed = f"allowed: {base.model_hash[:12]}, which is in use"
        again = f"voice_assist enroll {profile.name} --again makes it anew from its takes"
        raise VoiceProfileError(f"profile {profile.name!r} {found}, {allowed}; {again}")
    if not profile.has(model_file.NAME):
        return base
    if not isinstance(base, EmbeddedRecognizer):
        allowed = "the embedded model, or one trained by make train"
        raise VoiceProfileError(
            f"profile {profile.name!r} adapts {base.name!r}, allowed: {allowed}"
        )
    data = profile.read(model_file.NAME)
    state = model_file.read_model(data, base.model, base.model_hash)
    return PersonalRecognizer(base, state, profile.name, profile.digest)


def with_profile(config: VoiceConfig) -> tuple[VoiceConfig, bytes | None]:
    """The settings with the person's spellings and thresholds, and the voiceprint, if there is one.

    Raises:
        VoiceProfileError: As `profile_in_use`, or it was not learned from every phrase of another
            language than English.
        VoiceError: Spellings or thresholds cannot be used.
    """
    profile = _profile_of_language(config)
    if profile is None:
        return config, None
    config = with_spellings(config, profile)
    if profile.has(thresholds.NAME):
        own = thresholds.from_bytes(profile.read(thresholds.NAME))
        config = replace(config, commands=thresholds.overlay(config.commands, own))
    return config, profile.read(FILE) if profile.has(FILE) else None


def with_spellings(config: VoiceConfig, profile: VoiceProfile) -> VoiceConfig:
    """The settings with what the profile learned to be spellings of commands.

    Raises:
        VoiceError: They cannot be used.
    """
    if not profile.has(spellings.NAME):
        return config
    learned = spellings.from_bytes(profile.read(spellings.NAME))
    return replace(config, commands=spellings.overlay(config.commands, learned))


class PersonalRecognizer(EmbeddedRecognizer):
    """As the base, and as quick; the base it was made of stays as it is."""

    def __init__(
        self,
        base: EmbeddedRecognizer,
        state: dict[str, Tensor],
        profile: str = "",
        digest: str = "",
    ) -> None:
        """Copy the base and change it.

        Args:
            base: With a CTC head.
            state: Adapted tensors by their name in WhisperCtc.
            profile: Name of whose they are.
            digest: SHA-256 of that profile.
        """
        self.__dict__.update(vars(base))
        self.model = copy.deepcopy(base.model)
        self.model.load_state_dict(state, strict=False)
        self.model.eval()
        self._adapted()
        self._verifier = None  # it would refuse the very accent that was learned
        self.profile, self.profile_digest = profile, digest
