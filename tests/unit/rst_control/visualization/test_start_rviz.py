# SPDX-License-Identifier: BSD-3-Clause
"""The viewer is optional: with rviz it is started on our layout, without it that is said."""

import os
import shutil
import sys

import pytest

from rst_control.visualization import start_rviz


def test_without_rviz_it_says_how_to_get_it_and_fails(monkeypatch):
    monkeypatch.setattr(shutil, "which", lambda name: None)
    monkeypatch.setattr(os, "execv", lambda *_: 1 / 0)
    with pytest.raises(SystemExit, match="apt-get install rviz"):  # status 1, for it is no number
        start_rviz.main()


def test_rviz_gets_our_layout_and_what_roslaunch_says(monkeypatch):
    started = []
    monkeypatch.setattr(shutil, "which", lambda name: f"/bin/{name}")
    monkeypatch.setattr(os, "execv", lambda program, words: started.append((program, words)))
    monkeypatch.setattr(sys, "argv", ["viewer", "__name:=rviz"])
    start_rviz.main()
    ((program, words),) = started
    assert program == "/bin/rviz" and words[1] == "-d" and words[3:] == ["__name:=rviz"]
    assert start_rviz.LAYOUT.is_file() and words[2] == str(start_rviz.LAYOUT)
