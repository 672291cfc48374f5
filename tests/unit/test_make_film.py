# SPDX-License-Identifier: BSD-3-Clause
"""`make film` begins its own folder anew, and deletes no recording elsewhere."""

import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
RUN = 'RUN=python() { echo "$$*" >>ran; };'  # in place of Python and the workspace
PLAIN = {"PATH": "/usr/bin:/bin"}


@pytest.fixture
def film(tmp_path):
    """Makes the film in a folder; returns exit status, what was printed and what was run."""

    def film(*words):
        command = ["make", "-f", ROOT / "Makefile", "-o", ".setup/dev", RUN, "film", *words]
        done = subprocess.run(
            command, cwd=tmp_path, env=PLAIN, capture_output=True, text=True, check=False
        )
        ran = tmp_path / "ran"
        return done.returncode, done.stdout, ran.read_text("utf-8") if ran.exists() else ""

    return film


def recorded(folder):
    folder.mkdir(parents=True)
    (folder / "session.mcap").touch()
    return folder / "session.mcap"


def ran(out):
    return f"-m demo --film --out {out}\n-m demo.film {out}\n"


def test_a_recording_in_another_folder_is_kept_and_nothing_is_run(film, tmp_path):
    recording = recorded(tmp_path / "sessions/of a trial")
    status, printed, done = film(f"OUT={recording.parent}")
    assert status == 2 and done == ""
    assert printed == "OUT holds a recording; name a new folder\n"
    assert recording.exists()


@pytest.mark.parametrize("words", [(), ("OUT=sessions/film",)])
def test_the_film_of_before_is_made_anew(film, tmp_path, words):
    recording = recorded(tmp_path / "sessions/film")
    assert film(*words) == (0, "", ran("sessions/film"))
    assert not recording.exists()


def test_a_new_folder_is_taken(film):
    assert film("OUT=sessions/new") == (0, "", ran("sessions/new"))
