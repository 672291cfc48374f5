# SPDX-License-Identifier: BSD-3-Clause
"""A package's files are found in every space of catkin, or their absence is explained."""

import sys
from pathlib import Path

import pytest

from typed_config import (
    ResourceMissing,
    package_file,
    package_folder,
    package_version,
    repository,
)

ROOT = Path(__file__).resolve().parents[3]
PACKAGES = ("rst_control", "session_log", "typed_config", "voice_assist")
MANIFEST = "<package><name>x</name><version>{}</version></package>"
RELAY = "__path__ = [{relay!r}, {source!r}]\n"


@pytest.fixture
def layout(tmp_path, monkeypatch):
    """Makes a Python package and the catkin package around it; gives the package's name."""

    def make(name, modules, manifest, *, version="1.2.3", init=""):
        (tmp_path / modules / name).mkdir(parents=True)
        (tmp_path / modules / name / "__init__.py").write_text(init, encoding="utf-8")
        if manifest:
            (tmp_path / manifest).mkdir(parents=True, exist_ok=True)
            text = MANIFEST.format(version)
            (tmp_path / manifest / "package.xml").write_text(text, encoding="utf-8")
        monkeypatch.syspath_prepend(tmp_path / modules)
        monkeypatch.delitem(sys.modules, name, raising=False)
        return name

    return make


@pytest.mark.parametrize("package", PACKAGES)
def test_in_this_repository_it_is_the_source_folder(package):
    assert package_folder(package) == ROOT / "catkin_ws" / "src" / package
    assert repository(package) == ROOT


def test_the_four_packages_have_one_version_that_of_the_citation():
    versions = {package_version(package) for package in PACKAGES}
    (version,) = versions
    assert f"\nversion: {version}\n" in (ROOT / "CITATION.cff").read_text(encoding="utf-8")


def test_in_an_install_space_it_is_the_share_folder(layout, tmp_path):
    name = layout("installed_one", "lib/python3/dist-packages", "share/installed_one")
    assert package_folder(name) == tmp_path / "share" / "installed_one"
    assert package_version(name) == "1.2.3"
    assert repository(name) is None


def test_a_relay_of_a_devel_space_leads_to_the_source(layout, tmp_path):
    relay = str(tmp_path / "devel/lib/python3/dist-packages/relayed_one")
    source = str(tmp_path / "ws/src/relayed_one/src/relayed_one")
    (tmp_path / "devel/share/relayed_one/cmake").mkdir(parents=True)
    layout("relayed_one", "ws/src/relayed_one/src", "ws/src/relayed_one")
    init = RELAY.format(relay=relay, source=source)
    layout("relayed_one", "devel/lib/python3/dist-packages", "", init=init)
    assert package_folder("relayed_one") == tmp_path / "ws/src/relayed_one"


def test_a_package_without_manifest_is_named_with_the_places_searched(layout, tmp_path):
    name = layout("lost_one", "lib/python3/dist-packages", "")
    with pytest.raises(ResourceMissing, match=r"package\.xml of the package lost_one") as caught:
        package_folder(name)
    assert tmp_path / "share" / "lost_one" in caught.value.looked


def test_a_missing_file_is_named_with_its_package_and_folder():
    folder = ROOT / "catkin_ws" / "src" / "rst_control"
    with pytest.raises(
        ResourceMissing, match=f"config/no.yaml of the package rst_control.*{folder}"
    ):
        package_file("rst_control", "config/no.yaml")


def test_a_file_that_is_there_is_given_whole():
    assert package_file("rst_control", "config/rcm.yaml").is_file()
    assert package_file("rst_control", "urdf/gen3_openrst.urdf").is_file()


def test_a_manifest_without_version_is_refused(layout):
    name = layout("plain_one", "lib/python3/dist-packages", "share/plain_one", version="")
    with pytest.raises(ResourceMissing, match="version"):
        package_version(name)
