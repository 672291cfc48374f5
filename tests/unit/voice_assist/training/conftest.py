# SPDX-License-Identifier: BSD-3-Clause
"""Programs of training that refuse what they are asked."""

import sys

import pytest


@pytest.fixture
def refused(monkeypatch, capsys):
    """What a program says of its words; it ends with 2."""

    def run(module, *words):
        monkeypatch.setattr(sys, "argv", ["train", *map(str, words)])
        with pytest.raises(SystemExit) as ended:
            module.main()
        assert ended.value.code == 2
        return capsys.readouterr().err

    return run
