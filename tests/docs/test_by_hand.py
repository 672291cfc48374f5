# SPDX-License-Identifier: BSD-3-Clause
"""README's commands by hand can be given in the order in which they stand there."""

import yaml

from rst_control.registration.trocar import TrocarRegistrar
from tests.support.doc_lines import all_lines
from tests.unit.rst_control.support.executor_rig import AT_ONCE, Rig


def test_the_commands_of_the_readme_run_in_their_order():
    lines = [line.words for line in all_lines() if line.page == "README.md"]
    calls = [(words[2], yaml.safe_load(words[3])) for words in lines if words[0] == "rosservice"]
    rig = Rig().run(0.01)
    for _, request in calls[:-1]:
        do = rig.say if request["command"] in AT_ONCE else rig.finish_long
        do(request["command"])
        if request["command"] == "release":
            rig.robot.tissue = None  # that of this robot is wherever its jaws close
    service, request = calls[-1]
    reply = TrocarRegistrar(rig.context, rig.executor).ask(list(request["position"].values()), "")
    rig.run(0.01)
    assert service == "/rst_control/set_trocar" and reply.result(0).accepted, reply.result(0)
    assert [r["command"] for _, r in calls[:-1]] == [
        *("hey robot", "tense", "release", "withdraw", "insert")
    ]
