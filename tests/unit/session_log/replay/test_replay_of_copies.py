# SPDX-License-Identifier: BSD-3-Clause
"""A recovered copy is replayed where it is named, and a replay of nothing is no success."""

import pytest
import yaml

from session_log.cli import main
from session_log.mcap_file.reader import SessionReader
from session_log.mcap_file.recover import recover
from session_log.replay.command import REPLAY_CONFIG
from tests.unit.session_log.support import fake_pipeline
from tests.unit.session_log.support.fake_pipeline import MADE, PLANS
from tests.unit.session_log.support.voice_recording import SAME, ordinary
from typed_config import load_yaml


@pytest.fixture
def replayed(tmp_path, capsys):
    MADE.clear()
    PLANS.clear()
    path = tmp_path / "replay.yaml"
    data = {**load_yaml(REPLAY_CONFIG), "pipeline": f"{fake_pipeline.__name__}:make"}
    path.write_text(yaml.safe_dump(data))

    def run(session):
        with pytest.raises(SystemExit) as end:
            main(["replay", str(session), "--config", str(path)])
        shown = capsys.readouterr()
        return end.value.code, shown.out, shown.err

    return run


@pytest.mark.parametrize(("plan", "status"), [(SAME, 0), ({}, 1)])
def test_a_recovered_copy_that_is_named_is_replayed(tmp_path, replayed, plan, status):
    original = ordinary(tmp_path / "one" / "session.mcap")
    copy = original.with_name("session_recovered.mcap")
    recover(SessionReader(original), copy)
    PLANS.append(plan)
    code, out, _ = replayed(copy)
    assert code == status and f"{copy}: 2 utterances in 10.0 s" in out and len(MADE) == 1


def test_a_folder_in_which_no_recording_is_found_fails_with_a_message(tmp_path, replayed):
    (tmp_path / "one" / "a.mcap").mkdir(parents=True)  # the original's name, and no recording
    (tmp_path / "one" / "a_recovered.mcap").write_bytes(b"a copy")
    code, out, err = replayed(tmp_path / "one")
    assert (code, out) == (2, "") and "without any recording" in err
