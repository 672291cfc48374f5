# SPDX-License-Identifier: BSD-3-Clause
"""Each command of ROS in the documentation is executed by a test, or it is said why not."""

import pytest

from tests.integration.test_tutorial import steps
from tests.support.doc_lines import PAGES, ROOT, all_lines, doc_lines, marker_of, markers

PAGE = """
text with `rosrun in the_text`
```
rosrun a b --c 'd e'   # a comment
make test
rostopic pub -1 /t std_msgs/Empty
```
more
```yaml
rosrun: no command
```
"""


def test_only_commands_within_fences_are_collected_without_their_comments():
    lines = doc_lines(PAGE, "page.md")
    assert [line.text for line in lines] == [
        "rosrun a b --c 'd e'",
        "rostopic pub -1 /t std_msgs/Empty",
    ]
    assert lines[0].words == ["rosrun", "a", "b", "--c", "d e"]
    assert lines[0].number == 4


def test_every_line_is_executed_or_its_reason_is_given():
    unsaid = [
        f"{line.page}:{line.number}: {line.text}" for line in all_lines() if marker_of(line) is None
    ]
    assert not unsaid


def test_what_the_tutorial_is_to_execute_stands_in_its_terminals():
    executed = {line for _, line, _ in steps()}
    of_tutorial = [
        line for line in all_lines() if (m := marker_of(line)) and m.system == "tutorial"
    ]
    assert len(of_tutorial) > 10
    assert not [line for line in of_tutorial if line.text not in executed]


def test_every_marker_is_the_one_of_some_line():
    used = {marker_of(line) for line in all_lines()}
    assert not [marker.begins for marker in markers() if marker not in used]


@pytest.mark.parametrize("page", PAGES)
def test_fences_are_closed(page):
    text = (ROOT / page).read_text(encoding="utf-8")
    assert sum(line.startswith("```") for line in text.splitlines()) % 2 == 0


def test_tests_that_reasons_name_are_there():
    for marker in markers():
        for word in marker.reason.replace(";", " ").split():
            if word.startswith("tests/"):
                assert (ROOT / word.rstrip(".,")).is_file(), marker
