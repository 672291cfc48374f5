# SPDX-License-Identifier: BSD-3-Clause
"""The page of figures, from results of every age."""

import json
from functools import partial

import pytest
from rich.console import Console

from bench import page
from bench.catalogue import AREAS, measurable, parts
from bench.common.part import HUMAN
from bench.readme_rows import ReadmeRow
from bench.site.fixed_sessions import translated
from support import figures as support_figures
from support import product_code
from support.figures import Figure, rate, read, share, write
from support.product_code import HEARING, beside_hearing, definitions, identity

PART = measurable()["voice.armed"]
LEADS = ("set-points", "velocities")
MOVED = measurable()["site.turns"]
MACHINE = {"cpu": "AMD EPYC", "cores": 2, "load_at_start": 0.5, "date": "2026-11-25"}
SHARE = share("right", 9, 10, 95.0)


def on_file(folder, *figures, part=PART, **more):
    write(folder / f"{part.file}.json", figures, MACHINE, **more)
    return page.load(part, folder)


@pytest.fixture
def noted(tmp_path, monkeypatch):
    """Notes what versions of the code decide, or move; None: nothing was ever noted."""

    def note(place, content):
        file = tmp_path / "noted.json"
        if content is not None:
            file.write_text(json.dumps(content))
        monkeypatch.setattr(support_figures, place, file)

    return note


def rows(text, name):
    """Cells of the rows of a figure, by their heads."""
    found, head = [], []
    for line in text.splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if line.startswith("| figure |"):
            head = cells
        elif line.startswith(f"| {name} |"):
            found.append(dict(zip(head, cells, strict=True)))
    return found


def test_a_figure_has_one_number_per_cell_with_bounds_target_verdict_and_voices(tmp_path):
    on_file(tmp_path, SHARE, rate("false", 2, 4.0, voices="synthetic"), code="0123")
    missed, right = rows(page.text(tmp_path), "right")
    assert (right["measured"], right["unit"], right["target"]) == ("90", "%", "at least 95")
    assert right["95 %"] == "at least 60.58"  # 1 - p such that P(9 or more of 10) = 5 %
    assert (right["result"], right["voices"]) == ("**missed**", HUMAN)
    assert right["conditions"] == "9 of 10"
    assert missed["part"] == "`voice.armed`" and missed["measured"] == "90"
    (false,) = rows(page.text(tmp_path), "false")
    assert (false["target"], false["result"], false["voices"]) == ("none", "-", "synthetic")
    assert (false["measured"], false["95 %"]) == ("0.5", "at most 1.574")  # chi2, 6 degrees


@pytest.mark.parametrize(("share", "said"), [(0.066, True), (0.004, False)])
def test_what_the_host_of_a_virtual_machine_took_stands_beside_the_machine(tmp_path, share, said):
    write(tmp_path / f"{PART.file}.json", [SHARE], {**MACHINE, "stolen": share})
    page.load(PART, tmp_path)
    words = "The host of this virtual machine took 7 % of the processors."
    assert (words in page.text(tmp_path)) is said


def test_a_result_holds_the_share_that_the_host_took_meanwhile(tmp_path, monkeypatch):
    for name, values in (("_stolen", [2.0, 2.5]), ("time.monotonic", [100.0, 110.0])):
        monkeypatch.setattr(f"support.figures.{name}", partial(next, iter(values)))
    monkeypatch.setattr(support_figures, "ROOT", tmp_path)
    monkeypatch.setattr(support_figures, "RESULTS", tmp_path)
    support_figures.run("one", lambda: [SHARE], Console(quiet=True), bench="0123")
    result = json.loads((tmp_path / "one.json").read_text())
    assert result["machine"]["stolen"] == 0.05 and result["bench"] == "0123"


def test_what_an_older_result_lacks_is_a_dash_and_its_shares_are_per_cent(tmp_path):
    old = {"name": "heard", "value": 0.5, "unit": "of all", "target": 0.4, "at_most": False}
    path = tmp_path / f"{PART.file}.json"
    path.parent.mkdir(parents=True)
    path.write_text(json.dumps({"machine": {}, "figures": [{**old, "note": "", "met": True}]}))
    assert read(path) == [Figure("heard", 0.5, "of all", 0.4, at_most=False)]
    text = page.text(tmp_path)
    assert "-, commit -, -, - cores, load - at the start. **Which code was measured" in text
    (row,) = rows(text, "heard")
    assert (row["measured"], row["unit"], row["target"]) == ("50", "%", "at least 40")


def test_code_that_changed_after_it_was_measured_marks_the_result(tmp_path):
    assert on_file(tmp_path, SHARE).age is None
    assert on_file(tmp_path, SHARE, code=identity(PART.rooms)).age is True
    assert page.AGES[True] in page.text(tmp_path)
    assert on_file(tmp_path, SHARE, code="other").age is False
    assert page.AGES[False] in page.text(tmp_path)


def test_a_bench_that_changed_after_it_measured_marks_the_result(tmp_path):
    now = identity(PART.rooms)
    assert on_file(tmp_path, SHARE, code=now, bench=PART.bench).age is True
    assert on_file(tmp_path, SHARE, code=now, bench="other").age == page.BENCH
    text = page.text(tmp_path)
    assert page.AGES[page.BENCH] in text and page.AGES[True] not in text
    assert "1 of a bench that was changed since." in text
    assert on_file(tmp_path, SHARE, code="other", bench=PART.bench).age is False
    assert on_file(tmp_path, SHARE, code="other", bench="other").age is False


def test_a_result_that_moves_or_decides_the_same_is_of_an_older_bench_where_it_is(tmp_path, noted):
    noted("FIXED_SESSIONS", {f"set-points {code}": "a" for code in both(MOVED)})
    for bench, age in ((MOVED.bench, page.ALIKE), ("other", page.BENCH)):
        timed = Figure("IK near joint limits: solved within 10 ms", 100.0, "%", 99.9, False)
        result = on_file(tmp_path, SHARE, timed, part=MOVED, code="other", bench=bench)
        assert [result.age_of(figure) for figure in result.figures] == [age, False]


@pytest.mark.parametrize(
    ("file", "text", "is_other"),
    [
        ("bench/one.py", "from bench import two\nX = 2\n", True),
        ("bench/two.py", "from support.three import Y\nZ = 1\n", True),
        ("support/three.py", "Y = 4\n", True),
        ("bench/process.py", "P = 6\n", True),
        ("bench/others.py", "A = 7\n", False),
        ("support/three.py", "Y = 3  # as before\n", False),
    ],
)
def test_a_bench_is_its_module_and_what_that_uses(tmp_path, monkeypatch, file, text, is_other):
    found = []
    for folder, change in (("before", {}), ("after", {file: text})):
        files = {
            "bench/one.py": "from bench import two\nX = 1\nRUN = ['-m', 'bench.process']\n",
            "bench/two.py": "from support.three import Y\nZ = Y\n",
            "support/three.py": "Y = 3\n",
            "bench/process.py": "P = 5\n",
            "bench/others.py": "A = 6\n",
        }
        for name, content in (files | change).items():
            path = tmp_path / folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(content)
        monkeypatch.setattr(product_code, "ROOT", tmp_path / folder)
        found.append(product_code.bench_identity("bench.one"))
    assert (found[0] != found[1]) is is_other


@pytest.mark.parametrize(
    ("decided", "now", "age"),
    [
        ("a", {"code": identity(PART.rooms), "rest": "a"}, page.SAME),
        ("a", {"code": identity(PART.rooms), "rest": "b"}, False),
        ("a", {"code": "noted before it changed again", "rest": "a"}, False),
        ("", {"code": identity(PART.rooms), "rest": "a"}, False),
        ("a", None, False),
    ],
)
def test_changed_code_that_decides_the_same_on_fixed_clips_is_marked_so(
    tmp_path, noted, decided, now, age
):
    noted("DECISIONS", now)
    assert PART.decides == "rest"
    assert on_file(tmp_path, SHARE, code="other", decisions=decided).age == age


@pytest.mark.parametrize(
    ("known", "age"),
    [
        ({"other": "a", "now": "a"}, page.ALIKE),
        ({"other": "a", "now": "b"}, False),
        ({"other": "a"}, False),
        ({"now": "a"}, False),
        ({}, False),
        (None, False),
    ],
)
def test_changed_code_that_moves_the_same_in_fixed_sessions_is_marked_so(
    tmp_path, noted, known, age
):
    if known is not None:
        present = {"now": identity(MOVED.rooms)}
        known = {f"set-points {present.get(code, code)}": m for code, m in known.items()}
    noted("FIXED_SESSIONS", known)
    assert on_file(tmp_path, SHARE, part=MOVED, code="other").age == age
    if age:
        assert page.AGES[age] in page.text(tmp_path)


def test_what_the_fixed_sessions_never_do_is_of_other_code_though_they_are_the_same(
    tmp_path, noted
):
    part = measurable()["site.stops"]
    noted("FIXED_SESSIONS", {f"{lead} {code}": "a" for lead in LEADS for code in both(part)})
    assert on_file(tmp_path, SHARE, part=part, code="other").age is False


def test_sessions_that_are_led_otherwise_say_nothing(tmp_path, noted):
    noted("FIXED_SESSIONS", {f"velocities {code}": "a" for code in both(MOVED)})
    assert on_file(tmp_path, SHARE, part=MOVED, code="other").age is False
    part = measurable()["site.plant_velocities"]
    noted("FIXED_SESSIONS", {f"velocities {code}": "a" for code in both(part)})
    assert on_file(tmp_path, SHARE, part=part, code="other").age == page.ALIKE


def both(part):
    """Keys of some older code and of the present one."""
    return "other", identity(part.rooms)


def test_times_are_of_older_code_though_it_decides_the_same(tmp_path, noted):
    noted("DECISIONS", {"code": identity(PART.rooms), "rest": "a"})
    times = [Figure("late", 3.0, unit, 5.0) for unit in ("ms", "s", "% of a core")]
    result = on_file(tmp_path, SHARE, *times, code="other", decisions="a")
    assert [result.age_of(f) for f in result.figures] == [page.SAME, False, False, False]
    counted = "Of these verdicts 0 are of the present code, 1 of\nchanged code that does the same"
    assert counted in page.text(tmp_path)
    assert "3 of code that was changed since. Of 0 it is not recorded." in page.text(tmp_path)


def test_times_of_the_processor_are_of_older_code_though_it_moves_the_same(tmp_path, noted):
    part = measurable()["motion"]
    noted("FIXED_SESSIONS", {f"set-points {code}": "a" for code in both(part)})
    timed = [
        Figure("IK solved within 10 ms", 99.99, "%", 99.95, at_most=False),
        Figure("lock-step simulation over real time", 11.0, "times", 10.0, at_most=False),
        Figure("insertion: planning time p99", 40.0, "ms", 1000.0),
        Figure("grasp choice, verified: processor time p99", 4.0, "ms", 20.0),
        Figure("gate: time p99", 4.0, "ms", 20.0),
        Figure("control tick p99", 90.0, "us", 200.0),
        Figure("IK time median", 90.0, "us", 200.0),
    ]
    simulated = [
        Figure("IK solved to 1 um inside limits", 100.0, "%", 99.99, at_most=False),
        Figure("braking, 20 mm/s asked, hard limits: time max", 51.0, "ms", 60.0),
        Figure("tension: step settled beyond the travel, max", 0.4, "s", 0.5),
    ]
    result = on_file(tmp_path, *timed, *simulated, part=part, code="other")
    assert [result.age_of(figure) for figure in timed] == [False] * len(timed)
    assert [result.age_of(figure) for figure in simulated] == [page.ALIKE] * len(simulated)
    assert "its processor times are older" in page.AGES[page.ALIKE]


def test_a_real_time_factor_is_of_older_code_though_it_decides_the_same(tmp_path, noted):
    noted("DECISIONS", {"code": identity(PART.rooms), "rest": "a"})
    factor = Figure("real-time factor on talk", 0.2, "", 0.5)
    assert on_file(tmp_path, factor, code="other", decisions="a").age_of(factor) is False


@pytest.mark.parametrize(
    ("beside", "age"), [("the present", page.SAME), ("other", False), ("", False)]
)
def test_what_rests_on_more_than_hearing_is_the_same_only_where_that_is(
    tmp_path, noted, beside, age
):
    noted("DECISIONS", {"code": identity(HEARING), "motion": "a"})
    part = measurable()["safety.spoken"]
    other = beside_hearing(part.rooms) if beside == "the present" else beside
    facts = {"code": "other", "decisions": "a", "beside_hearing": other}
    assert on_file(tmp_path, SHARE, part=part, **facts).age == age


@pytest.mark.parametrize(
    ("figure", "verdict"),
    [
        (Figure("a", 90.0, "%", 80.0, at_most=False, lower=70.0), page.FEW),
        (Figure("a", 90.0, "%", 80.0, at_most=False, lower=80.0), "met"),
        (Figure("a", 70.0, "%", 80.0, at_most=False, lower=60.0), "**missed**"),
        (Figure("a", 0.0, "per h", 0.5, upper=13.0), page.FEW),
        (Figure("a", 0.0, "per h", 0.5), page.UNBOUND),
        (Figure("a", 90.0, "%", 80.0, at_most=False), page.UNBOUND),
        (Figure("a", 90.0, "%", 80.0, at_most=False, upper=95.0), page.UNBOUND),
        (Figure("a", 70.0, "%", 80.0, at_most=False), "**missed**"),
        (Figure("a: needless stops per hour", 0.0, "", 0.0), page.UNBOUND),
        (Figure("a: errors within twice the estimated sigma", 0.97, "", 0.95, False), page.UNBOUND),
        (Figure("a: within twice the stated sigma", 0.97, "", 0.95, False), page.UNBOUND),
        (Figure("not tared: trusted", 0.0, "", 0.0), page.UNBOUND),
        (Figure("overshoot max", 0.0, "%", 5.0), "met"),
        (Figure("shaft off the trocar, max", 0.2, "mm", 1.0), "met"),
        (Figure("missed", 0.0, "", 0.0), "met"),
        (Figure("a", 0.0, "per h", upper=13.0), ""),
    ],
)
def test_what_the_bound_does_not_show_is_not_called_met_alone(figure, verdict):
    assert page._verdict(figure) == verdict


def test_the_head_counts_verdicts_without_a_bound_and_of_changed_code(tmp_path):
    bare = Figure("heard", 99.0, "%", 95.0, at_most=False)
    on_file(tmp_path, SHARE, Figure("longest", 3.0, "ms", 5.0), bare, bare, code="other")
    head = page.text(tmp_path).partition("## Missed")[0]
    assert "3 targets are met and 1 missed." in head
    assert "2 of those met are shares or rates without a bound" in head
    assert "1 more are single values, maxima or counts" in head
    assert "4 of code that was changed since." in head


@pytest.mark.parametrize(
    ("name", "voices"),
    [("people: stop missed", "human"), ("stop, synthetic", "synthetic"), ("sounds", "human")],
)
def test_whose_voices_an_older_result_is_of_stands_in_its_name(tmp_path, name, voices):
    result = on_file(tmp_path, Figure(name, 1.0, "%"))
    assert PART.voices == HUMAN and result.voices(result.figures[0]) == voices


def test_a_part_without_a_result_is_named(tmp_path):
    text = page.text(tmp_path)
    missing = [part.name for part in parts() if f"ONLY={part.name}`. Not measured yet" in text]
    assert set(missing) == set(measurable())


def test_a_result_that_rests_on_less_than_the_whole_says_so(tmp_path):
    on_file(tmp_path, Figure("measured", 3, "trials", 10, at_most=False), SHARE)
    text = page.text(tmp_path)
    assert "Rests on 3 of 10 trials." in text and not rows(text, "measured")


def test_the_readme_needs_its_marks_and_figures_that_are_there_once(tmp_path, monkeypatch):
    with pytest.raises(ValueError, match=r"README.md: no lines <!-- figures"):
        page.in_readme("words")
    monkeypatch.setattr(page, "ROWS", (ReadmeRow("so much", PART.name, "right"),))
    for figures in ((), (SHARE, SHARE)):
        on_file(tmp_path, *figures)
        with pytest.raises(ValueError, match="where one is wanted"):
            page.readme(tmp_path)
    on_file(tmp_path, SHARE)
    assert "| so much (human) | 90 % (9 of 10) | ≥ 95 | **missed** |" in page.readme(tmp_path)


def test_the_readme_says_of_how_many_a_percentile_is(tmp_path, monkeypatch):
    monkeypatch.setattr(page, "ROWS", (ReadmeRow("so late", PART.name, "late p95"),))
    on_file(tmp_path, Figure("late p95", 180.0, "ms", note="n=60"))
    assert "| so late (human) | 180 ms (n=60) | none |" in page.readme(tmp_path)


def test_every_area_has_a_part():
    assert all(area.parts for area in AREAS)


def test_a_moved_commented_or_reordered_definition_is_the_same_code():
    before = "import a\n\ndef f(x):\n    return x + 1\n\nY = 2\n"
    after = (
        '"""Words."""\nfrom b import a\nY = 2  # two\ndef f(x):\n    """F."""\n    return x + 1\n'
    )
    assert sorted(definitions(before)) == sorted(definitions(after))
    assert definitions(before) != definitions(before.replace("+ 1", "+ 2"))


def test_rooms_that_are_not_there_are_named():
    with pytest.raises(FileNotFoundError, match="rst_control/nowhere"):
        identity(["rst_control/nowhere"])


def test_digests_of_another_processor_are_translated_by_the_versions_that_ran_on_both():
    known = {"set-points old": "a", "set-points older": "a", "velocities old": "a"}
    here = {**known, "set-points old": "b"}
    found = translated(known, here)
    assert found == {"set-points old": "b", "set-points older": "b", "velocities old": "a"}
    with pytest.raises(ValueError, match="set-points: a has two digests"):
        translated(known, {"set-points old": "b", "set-points older": "c"})
