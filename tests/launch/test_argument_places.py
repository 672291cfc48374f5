# SPDX-License-Identifier: BSD-3-Clause
"""Every argument of every launch file arrives at the node or setting that it is meant for."""

import functools
import shutil

import pytest

from tests.launch.argument_places import ROOT, bases, rows, unmet
from tests.support import launch_reading
from tests.support.launch_reading import read
from typed_config.launch_line import arguments

LAUNCH = ROOT / "launch"
PACKAGES = ROOT / "catkin_ws" / "src"
LIMITS = PACKAGES / "rst_control" / "config" / "kinova_limits.yaml"
URDF = PACKAGES / "rst_control" / "urdf" / "gen3_openrst.urdf"


@functools.cache
def reading(file, *more):
    """A file with the arguments of its base and more, in which a later one counts."""
    words = [word.replace("@kinova_limits", str(LIMITS)) for word in (*bases()[file], *more)]
    last = {word.partition(":=")[0]: word for word in words}
    return read([str(LAUNCH / file), *last.values()])


@pytest.fixture(scope="module")
def sample(tmp_path_factory):
    """A value that differs from the default; files get a setting of their own."""
    folder = tmp_path_factory.mktemp("own settings")

    def sample(word):
        if not word.startswith("@"):
            return word
        kept = folder / word[1:]
        if word == "@text":
            kept.write_text(URDF.read_text("utf-8") + "<!-- another -->\n", "utf-8")
        elif word == "@file":
            kept.write_text("{of_this_test: {file: 1}}\n", "utf-8")
        elif not kept.exists():
            for package in ("rst_control", "voice_assist", "session_log"):
                shutil.copytree(PACKAGES / package / "config", kept, dirs_exist_ok=True)
            for file in kept.glob("*.yaml"):
                with file.open("a", encoding="utf-8") as text:
                    text.write(f"\nof_this_test: {file.name}\n")
        return str(kept)

    return sample


def test_the_table_has_every_argument_of_every_file():
    declared = {(f.name, name) for f in LAUNCH.glob("*.launch") for name in arguments(f)}
    assert {(row.file, row.name) for row in rows()} == declared


@pytest.mark.parametrize("row", rows(), ids=lambda row: f"{row.file.split('.')[0]}-{row.name}")
def test_an_argument_reaches_its_places(row, sample):
    value = sample(row.sample)
    assert unmet(row, value, reading(row.file)) == row.places, "the sample is the default"
    assert not unmet(row, value, reading(row.file, f"{row.name}:={value}"))


OWN = {
    "audio.yaml": ('device: ""', 'device: "headset"'),
    "recognizer.yaml": ("device: cpu", "device: cuda"),
    "profile.yaml": ("name: none", "name: ada"),
    "alarms.yaml": (
        "is_enabled: true       # false: alarms",
        "is_enabled: false      # false: alarms",
    ),
}


@pytest.mark.parametrize("file", ["system.launch", "two_hosts.launch"])
def test_settings_of_an_own_folder_count_where_no_argument_is_given(file, tmp_path):
    folder = tmp_path / "own"
    shutil.copytree(PACKAGES / "voice_assist" / "config", folder)
    for name, (shipped, own) in OWN.items():
        text = (folder / name).read_text("utf-8")
        assert shipped in text
        (folder / name).write_text(text.replace(shipped, own, 1), "utf-8")
    found = reading(file, f"config:={folder}").parameters
    assert found["/voice_assist/audio/microphone/device"] == "headset"
    assert found["/voice_assist/recognizer/device"] == "cuda"
    assert found["/voice_assist/profile/name"] == "ada"
    assert found["/alarms/sound/is_enabled"] is False


def marked(settings):
    """The same settings, with each value one that no launch file gives."""
    if isinstance(settings, dict):
        return {name: marked(value) for name, value in settings.items()}
    return OF_A_FILE


OF_A_FILE = "of a file"
BY_THE_LAUNCH = {  # what the page of these arguments says, whatever the files say
    "kinova.launch": {
        *("/robot/simulator/mode", "/robot/kinova/driver/name", "/robot/kinova/tool/name"),
        *("/kinova_bridge/bridge/arm/namespace", "/kinova_bridge/bridge/tool/namespace"),
        *("/kinova_bridge/bridge/believed/arm", "/kinova_bridge/bridge/believed/tool"),
        *("/kinova_guard/bridge/arm/namespace", "/controller/scene/trocar"),
        *("/controller/controller/homing", "/controller/controller/first_motion"),
        *("/controller/controller/speed/scale", "/robot/scene/trocar"),
        *("/robot/kinova/force_sensor_topic", "/kinova_guard/bridge/believed/arm"),
    },
    "kinova_guard.launch": {
        *("/kinova_guard/bridge/arm/namespace", "/kinova_guard/bridge/believed/arm"),
    },
}


@pytest.mark.parametrize("file", sorted(file.name for file in LAUNCH.glob("*.launch")))
def test_what_a_settings_file_says_counts_where_no_argument_is_given(file, monkeypatch):
    names, parse = set(), launch_reading._parsed

    def parsed(text):
        settings = parse(text)
        if "\n" not in text.strip():  # of a launch file
            return settings
        names.update(leaves(settings))
        return marked(settings)

    def of_a_file(name):
        return any(name.endswith(leaf) for leaf in names) and "checked_settings" not in name

    def leaves(settings, above=""):
        if not isinstance(settings, dict):
            return {above}
        return {leaf for name in settings for leaf in leaves(settings[name], f"{above}/{name}")}

    monkeypatch.setattr(launch_reading, "_parsed", parsed)
    words = [word.replace("@kinova_limits", str(LIMITS)) for word in bases()[file]]
    found = read([str(LAUNCH / file), *words]).parameters
    hidden = {name for name, value in found.items() if value != OF_A_FILE and of_a_file(name)}
    assert hidden == BY_THE_LAUNCH.get(file, set())


def test_a_recording_that_is_named_is_heard_in_place_of_a_microphone():
    assert reading("system.launch", "wav:=/a.wav").parameters["/voice_assist/audio/source"] == "wav"
    both = reading("system.launch", "wav:=/a.wav", "source:=topic").parameters
    assert both["/voice_assist/audio/source"] == "topic"


@pytest.mark.parametrize("file", ["system.launch", "kinova.launch"])
def test_overrides_say_what_a_lost_recording_leads_to_also_where_none_is_made(file, tmp_path):
    own, place = tmp_path / "own.yaml", "/controller/controller/recording/on_loss"
    own.write_text("{controller: {recording: {on_loss: stop}}}", "utf-8")
    assert reading(file, "record:=false").parameters[place] == "ignore"
    own_words = ("record:=false", f"controller_overrides:={own}")
    assert reading(file, *own_words).parameters[place] == "stop"


def test_overrides_count_over_the_arguments_of_the_same_setting(tmp_path):
    own = tmp_path / "own.yaml"
    own.write_text("{simulator: {plant: lab, gui: true}, kinova: {driver: {name: left}}}", "utf-8")
    found = reading("robot.launch", f"overrides:={own}").parameters
    assert found["/robot/simulator/plant"] == "lab" and found["/robot/simulator/gui"] is True
    assert found["/robot/kinova/driver/name"] == "left"
    own.write_text("{bridge: {arm: {namespace: left}}}", "utf-8")
    found = reading("kinova.launch", f"bridge_overrides:={own}").parameters
    assert found["/kinova_bridge/bridge/arm/namespace"] == "left"
    assert found["/kinova_guard/bridge/arm/namespace"] == "left"
    own.write_text("{scene: {trocar: [0.1, 0.2, 0.3]}}", "utf-8")
    found = reading("kinova.launch", f"simulation_overrides:={own}").parameters
    assert found["/robot/scene/trocar"] == [0.1, 0.2, 0.3]
    assert found["/controller/scene/trocar"] == [0.4, 0.0, 0.4]
