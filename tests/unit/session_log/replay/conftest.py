# SPDX-License-Identifier: BSD-3-Clause
"""A replay of recordings by a pipeline that does what a test says."""

import json

import pytest
import yaml

from session_log.cli import main
from session_log.replay.command import REPLAY_CONFIG
from tests.unit.session_log.support import fake_pipeline
from tests.unit.session_log.support.fake_pipeline import MADE, PLANS
from typed_config import load_yaml


@pytest.fixture
def config(tmp_path):
    """The settings with a pipeline that does what the test says, without runs of other tests."""
    MADE.clear()
    PLANS.clear()
    path = tmp_path / "replay.yaml"
    data = {**load_yaml(REPLAY_CONFIG), "pipeline": f"{fake_pipeline.__name__}:make"}
    path.write_text(yaml.safe_dump(data))
    return path


@pytest.fixture
def replayed(tmp_path, config, capsys):
    def run(*words):
        out = tmp_path / "result.json"
        given = ["replay", *map(str, words), "--config", str(config), "--json", str(out)]
        with pytest.raises(SystemExit) as end:
            main(given)
        shown = capsys.readouterr()
        return end.value.code, shown.out, shown.err, json.loads(out.read_text())

    return run
