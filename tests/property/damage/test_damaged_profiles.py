# SPDX-License-Identifier: BSD-3-Clause
"""Whatever happens to the bytes of a profile: it is refused by name, or it is what was written."""

from __future__ import annotations

import shutil
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.unit.voice_assist.support.records import take
from typed_config import ConfigError
from voice_assist.errors import VoiceError
from voice_assist.profile import thresholds
from voice_assist.profile.manifest import Manifest, from_bytes, to_bytes
from voice_assist.profile.profile import (
    VoiceProfile,
    VoiceProfileError,
    create_profile,
    open_profile,
)

FILES = ("profile.json", "takes/0001.wav", "settings.json")


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> VoiceProfile:
    made = create_profile("ada", "ab" * 32, tmp_path_factory.mktemp("whole"))
    made.add_take(np.zeros(400, np.float32), take("stop"))
    chosen = thresholds.Settings(
        commands=(thresholds.Setting(phrase="stop", least_confidence=0.5),)
    )
    made.put("settings.json", to_bytes(chosen))
    return made


def read_all(root: Path) -> dict[str, bytes]:
    profile = open_profile("ada", root)
    profile.check()
    names = [*(t.file for t in profile.manifest.takes), *(f.name for f in profile.manifest.files)]
    return {name: profile.read(name) for name in names}


@settings(max_examples=60)
@given(
    name=st.sampled_from(FILES),
    at=st.floats(0.0, 1.0, exclude_max=True),
    value=st.integers(0, 255),
    kind=st.sampled_from(("change", "cut", "insert")),
)
def test_damage_is_named_or_harmless(
    whole: VoiceProfile, name: str, at: float, value: int, kind: str
) -> None:
    before = read_all(whole.folder.parent)
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder)
        shutil.copytree(whole.folder, root / "ada")
        path = root / "ada" / name
        data = bytearray(path.read_bytes())
        index = int(at * len(data))
        if kind == "change":
            data[index] = value
        elif kind == "cut":
            del data[index:]
        else:
            data.insert(index, value)
        path.write_bytes(bytes(data))
        try:
            after = read_all(root)
        except VoiceProfileError as error:
            assert "'ada'" in str(error)
        else:
            assert {n: after[n] for n in after if n in before} == {n: before[n] for n in after}


@settings(max_examples=100)
@given(st.binary(max_size=300))
def test_any_bytes_as_a_manifest_are_refused(data: bytes) -> None:
    with pytest.raises((ConfigError, ValueError)):
        from_bytes(data, "profile.json")


@settings(max_examples=100)
@given(st.binary(max_size=200))
def test_any_bytes_as_thresholds_are_refused(data: bytes) -> None:
    with pytest.raises(VoiceError, match=r"settings\.json"):
        thresholds.from_bytes(data)


@settings(max_examples=60)
@given(st.text(max_size=20))
def test_whatever_a_recording_is_called_its_profile_can_be_read(source: str) -> None:
    with tempfile.TemporaryDirectory() as folder:
        made = create_profile("ada", "ab" * 32, Path(folder))
        try:
            made.add_take(np.zeros(400, np.float32), replace(take("stop"), source=source))
        except VoiceProfileError as error:
            assert "source" in str(error)
        found = open_profile("ada", Path(folder))
        found.check()
        assert found.manifest == made.manifest


def test_a_manifest_comes_back_as_it_was_written(whole: VoiceProfile) -> None:
    found: Manifest = from_bytes(to_bytes(whole.manifest), "profile.json")
    assert found == whole.manifest
