# SPDX-License-Identifier: BSD-3-Clause
"""What the figures show, read back from what was drawn."""

import io
import math
from array import array
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import FillBetweenPolyCollection
from PIL import Image

from session_log.mcap_file.reader import SessionReader
from session_log.mcap_file.summary import RecordingSummary
from session_log.report.figures import POOL_FIGURES, SessionMaterial
from session_log.report.figures.joints import JointsFigure
from session_log.report.figures.loops import LoopsFigure
from session_log.report.figures.pictures import PicturesFigure
from session_log.report.figures.rcm import RcmErrorFigure, why_no_error
from session_log.report.figures.style import NARROW, RED, WIDE, thin, with_gaps
from session_log.report.figures.tension import TensionFigure
from session_log.report.figures.timeline import TimelineFigure, timeline_labels
from session_log.report.pool.pool import Pool
from session_log.report.session.analysis import command_rows
from session_log.report.session.extract import extract
from session_log.report.session.session_data import RecordedPicture, SampledTable, SessionData, Span
from session_log.report.session.shaft import rcm_from_joints
from session_log.report.session.summary import GivenCommand, summarise
from session_log.report.session.trials import NOTHING, PhraseTrial, trials
from tests.unit.session_log.report.session.test_joint_margins import urdf

POOLED = {figure.name: figure for figure in POOL_FIGURES}


@pytest.fixture(scope="module")
def material(story, report_config):
    data = extract(SessionReader(story[0]), report_config)
    found = tuple(trials(data, report_config))
    rcm = rcm_from_joints(data, report_config)
    return SessionMaterial(data, command_rows(data, report_config), report_config, rcm, found)


def pool_of(material, **changes):
    summary = summarise("s", material.data, material.rows, material.rcm, material.config)
    pool = Pool(material.config)
    pool.add(Path("s.mcap"), None, replace(summary, **changes))
    return pool


def words_of(figure):
    """Every text in a figure, legends and axes included."""
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    texts = [t for t in figure.findobj(lambda a: hasattr(a, "get_text")) if t.get_visible()]
    return [t.get_text() for t in texts if t.get_text()]


@pytest.mark.parametrize("layout", [WIDE, NARROW], ids=["wide", "narrow"])
def test_the_timeline_marks_the_trocars_change_and_what_was_not_heard(material, layout):
    words = words_of(TimelineFigure().draw(material, layout))
    assert "trocar set" in words and "refused" in words and "stop received" in words
    assert "meant: stop (nothing heard)" in words
    assert "tense" in words and "time since the session began [s]" in words


def test_a_crowded_timeline_still_names_what_went_wrong(material):
    row = material.rows[0]
    many = [
        replace(row, heard=replace(row.heard, decision=0.1 * k), command="x" * 9)
        for k in range(400)
    ]
    wrong = (*material.trials, PhraseTrial(10.0, "release", NOTHING, ""))
    crowded = replace(material, rows=many, trials=wrong)
    words = words_of(TimelineFigure().draw(crowded, WIDE))
    assert "x" * 9 not in words and "meant: release (nothing heard)" in words
    assert "402 without room for a label" in words  # two more were ignored talk
    assert not any(
        "without room" in word for word in words_of(TimelineFigure().draw(material, WIDE))
    )


def test_a_session_without_intentions_marks_nothing_as_misheard(material):
    words = words_of(TimelineFigure().draw(replace(material, trials=()), WIDE))
    assert not any(word.startswith("meant") for word in words)


@pytest.mark.parametrize("layout", [WIDE, NARROW], ids=["wide", "narrow"])
@pytest.mark.parametrize("name", sorted(POOLED))
def test_pooled_figures_name_every_command_and_the_unit(material, name, layout):
    words = words_of(POOLED[name].draw(pool_of(material), layout))
    commands = {entry.command for entry in material.config.paper.latency}
    assert commands <= set(words)
    units = {"accuracy": "[%]", "latency": "[s]", "confusion": "taken for"}
    assert any(units[name] in word for word in words)


def test_many_points_are_drawn_in_bounded_number(material):
    given = tuple(
        GivenCommand("tense", 0.1, 0.001 * k, "accepted", "", False) for k in range(20_000)
    )
    figure = POOLED["latency"].draw(pool_of(material, given=given), WIDE)
    points = sum(len(line.get_xdata()) for line in figure.axes[0].lines)
    assert 500 < points < 3000


def test_captions_count_what_was_wrong(material):
    pool = pool_of(material)
    assert "11 of 12" in POOLED["accuracy"].caption(pool)
    assert "Wrong: 1 of 14, of which 0 were taken for a command" in POOLED["confusion"].caption(
        pool
    )
    extra = (*material.trials, PhraseTrial(50.0, "tense", "release", "release"))
    assert "Wrong: 2 of 15, of which 1 were taken for a command" in POOLED["confusion"].caption(
        pool_of(material, trials=extra)
    )


def test_the_limit_of_the_tension_is_drawn_where_the_settings_name_it(material):
    settings = {"other": "x: [", "controller": "tension: {limit: 2.4, maximum: 2.0}\nx: 1"}
    condition = replace(material.data.recording.condition, metadata=[("parameters", settings)])
    data = replace(material.data, recording=replace(material.data.recording, condition=condition))
    assert "limit 2.4 N" in words_of(TensionFigure().draw(replace(material, data=data), WIDE))
    assert not any("limit" in w for w in words_of(TensionFigure().draw(material, WIDE)))


def test_the_axis_of_the_rcm_error_ends_where_rounding_begins(material):
    nothing = SessionData(RecordingSummary(material.data.recording.condition))
    tiny = np.full(5, 1e-18)
    rcm = replace(material.rcm, time=np.arange(5.0), error=tiny, moving=np.ones(5, bool))
    rcm = replace(rcm, peak_time=np.empty(0), peak=np.empty(0))
    figure = RcmErrorFigure().draw(replace(material, rcm=rcm, data=nothing), WIDE)
    low, high = figure.axes[0].get_ylim()
    assert low == pytest.approx(0.01) and high == pytest.approx(100.0)  # µm
    assert min(figure.axes[0].lines[0].get_ydata()) == pytest.approx(0.01)


SUM = "$50% off, only $60"  # as mathematics it cannot be read


def test_recorded_text_with_dollar_signs_is_drawn_as_it_is(material):
    row = replace(material.rows[0], command=SUM)
    data = replace(
        material.data,
        phases=[Span(0.0, 20.0, SUM)],
        joints=SampledTable(("time", SUM), array("d", [0.0, 0.1])),
    )
    odd = replace(material, data=data, rows=[row])
    assert words_of(TimelineFigure().draw(odd, WIDE)).count(SUM) == 2
    assert SUM in words_of(JointsFigure().draw(odd, WIDE))


@pytest.mark.parametrize("name", sorted(POOLED))
def test_a_command_with_dollar_signs_is_drawn_as_it_is(material, name):
    given = (GivenCommand(SUM, 0.1, 0.2, "accepted", "", False),)
    changes = {"given": given, "trials": (PhraseTrial(1.0, SUM, SUM, SUM),)}
    assert SUM in words_of(POOLED[name].draw(pool_of(material, **changes), WIDE))


def test_a_tension_of_the_controller_that_is_no_number_leaves_the_others_drawn(material):
    table = SampledTable(material.data.controller.columns)
    tension, target = np.array([1.0, math.nan, math.inf]), np.full(3, 2.0)
    table.extend(np.arange(3.0), np.zeros(3), tension, target, np.zeros(3))
    nothing = SampledTable(material.data.tension.columns)
    odd = replace(material, data=replace(material.data, tension=nothing, controller=table))
    figure = TensionFigure().draw(odd, WIDE)
    assert list(figure.axes[0].lines[0].get_ydata()) == [1.0]
    assert figure.axes[0].get_ylim()[1] == pytest.approx(2.5)
    assert summarise("s", odd.data, [], odd.rcm, odd.config).tension == 1.0
    assert "Largest: 1.00 N. With a target set: 1.00 N." in TensionFigure().caption(odd)


def test_a_robot_without_a_sensor_has_no_figure_of_its_tension(material):
    nothing = SampledTable(material.data.tension.columns)
    recording = replace(material.data.recording, topics={})
    unmeasured = replace(material.data, tension=nothing, recording=recording)
    assert len(unmeasured.controller) and TensionFigure().can_draw(material)
    assert not TensionFigure().can_draw(replace(material, data=unmeasured))


def test_the_timeline_counts_refusals_of_what_was_said_and_device_calls_apart(material):
    words = "11 taken for a command, 2 not; of the commands, the controller refused 1. Bars"
    assert words in TimelineFigure().caption(material)
    refused = next(row for row in material.rows if row.outcome == "refused")
    by_pedal = replace(refused, heard=None, caller="/pedal")
    failed = replace(refused, outcome="failed", command="light on", caller="devices")
    more = replace(material, rows=[*material.rows, by_pedal, failed])
    caption = TimelineFigure().caption(more)
    assert "the controller refused 1. Device calls that failed: 1." in caption
    marked = {label.words for label in timeline_labels(more) if label.color == RED}
    assert marked == {"tense", "light on"}


def joints_of(material, **positions):
    """The material with these joints: a turning one to 1 rad, a sliding one to 0.1 m."""
    table = SampledTable(("time", *positions))
    table.extend(np.arange(3.0), *map(np.array, positions.values()))
    model = urdf(turn=("revolute", -1.0, 1.0), slide=("prismatic", 0.0, 0.1))
    return replace(material, data=replace(material.data, joints=table, urdf=model))


def test_sliding_joints_are_drawn_in_millimetres_beside_turning_ones_in_degrees(material):
    odd = joints_of(material, turn=[0.0, math.nan, 0.5], slide=[0.02, 0.04, 0.05])
    figure = JointsFigure().draw(odd, WIDE)
    words = words_of(figure)
    assert "28.6°" in words and "20.0\u00a0mm" in words and not any("nan" in w for w in words)
    bars = {
        ax.get_xlabel().split()[1]: [(b.get_x(), b.get_width()) for b in ax.patches]
        for ax in figure.axes
    }
    assert bars == {
        "[°]": [pytest.approx((-57.3, 114.6), abs=0.1), pytest.approx((0.0, 28.6), abs=0.1)],
        "[mm]": [pytest.approx((0.0, 100.0)), pytest.approx((20.0, 30.0))],
    }
    caption = JointsFigure().caption(odd)
    assert "Smallest margin: 28.6° (turn)." in caption
    assert "Smallest margin of a sliding joint: 20.0\u00a0mm (slide)." in caption
    assert "Positions that are not finite, left out: 1 of turn." in caption


def test_a_joint_without_any_finite_position_has_no_bar(material):
    odd = joints_of(material, turn=[math.nan] * 3, slide=[0.02] * 3)
    figure = JointsFigure().draw(odd, WIDE)
    assert len(figure.axes[0].patches) == 1 and "not finite" in words_of(figure)
    assert "names no joint limits" not in JointsFigure().caption(odd)


def test_a_thinned_curve_keeps_its_extremes_and_its_gaps():
    time, value = np.arange(1000.0), np.sin(np.arange(1000.0))
    value[500:520] = math.nan
    value[510], value[700] = 5.0, -5.0
    shown, kept = thin(time, value, 100)
    assert np.nanmax(kept) == 5.0 and np.nanmin(kept) == -5.0 and len(kept) <= 102
    assert 500.0 in shown[np.isnan(kept)]


def test_a_line_does_not_lead_across_silence():
    time = np.concatenate([np.arange(0.0, 1.0, 0.02), np.arange(5.0, 6.0, 0.02)])
    shown, value = with_gaps(time, np.ones(100))
    assert list(np.flatnonzero(np.isnan(value))) == [50] and len(shown) == 101
    slow = np.arange(5.0)  # a sensor that reports once a second
    assert np.isfinite(with_gaps(slow, slow)[1]).all()


def silent(material):
    """The material without what was recorded from 20 to 30 s."""
    tables = {}
    for name in ("controller", "tension", "sound"):
        table = getattr(material.data, name)
        kept = [table[c][(table["time"] < 20.0) | (table["time"] > 30.0)] for c in table.columns]
        tables[name] = SampledTable(table.columns)
        tables[name].extend(*kept)
    return replace(material, data=replace(material.data, **tables))


@pytest.mark.parametrize("drawn", [RcmErrorFigure, TensionFigure])
def test_curves_have_gaps_where_nothing_was_recorded(material, drawn):
    (line, *_) = drawn().draw(silent(material), WIDE).axes[0].lines
    time = line.get_xdata()[np.isnan(line.get_ydata())]
    assert len(time) == 1 and 19.0 < time[0] <= 20.0


def test_the_sound_of_the_timeline_has_gaps_where_nothing_was_recorded(material):
    figure = TimelineFigure().draw(silent(material), WIDE)
    (sound,) = (c for c in figure.axes[0].collections if isinstance(c, FillBetweenPolyCollection))
    assert len(sound.get_paths()) == 2


@pytest.mark.parametrize(
    ("parts", "expected"),
    [
        ({"lacking": "no trocar", "states": 0}, "No state of the controller was recorded. Not"),
        ({"lacking": "no trocar", "states": 3}, "inside the patient. Not computed from the joint"),
        ({"lacking": "", "states": 0}, "inside the patient. No state of the controller"),
        ({"lacking": "", "states": 3}, "holds no moment with the tool inside the patient."),
    ],
)
def test_why_there_is_no_rcm_error_is_said(material, parts, expected):
    table = SampledTable(material.data.controller.columns)
    table.extend(np.arange(3.0)[: parts["states"]], *np.full((4, parts["states"]), math.nan))
    rcm = replace(material.rcm, error=material.rcm.error * math.nan, lacking=parts["lacking"])
    rcm = replace(rcm, peak=rcm.peak * math.nan)
    odd = replace(material, data=replace(material.data, controller=table), rcm=rcm)
    assert not RcmErrorFigure().can_draw(odd) and expected in why_no_error(odd)


def test_monochrome_pictures_are_grey_between_the_limits_of_their_type(material):
    for kind, mode in (("png", "L"), ("jpeg", "L"), ("png", "I;16")):
        buffer = io.BytesIO()
        Image.new(mode, (8, 8), 60).save(buffer, kind)
        pictures = [RecordedPicture(1.0, kind, buffer.getvalue())]
        odd = replace(material, data=replace(material.data, pictures=pictures))
        (shown,) = PicturesFigure().draw(odd, WIDE).axes[0].images
        assert shown.cmap.name == "gray"
        assert shown.get_clim() == ((0.0, 255.0) if kind == "jpeg" else (0.0, 1.0))


def test_no_picture_is_shown_where_none_is_wanted(material):
    none = replace(material, config=replace(material.config, pictures=0))
    assert PicturesFigure().can_draw(material) and not PicturesFigure().can_draw(none)


def test_the_longest_latency_is_drawn_of_however_many(material):
    times = [0.01 * k for k in range(1502)]
    given = tuple(GivenCommand("tense", 0.1, t, "accepted", "", False) for t in times)
    lines = POOLED["latency"].draw(pool_of(material, given=given), WIDE).axes[0].lines
    assert max(max(line.get_xdata(), default=0.0) for line in lines) == times[-1]


def test_the_caption_of_the_loops_names_the_last_bin(material):
    assert LoopsFigure().caption(material).endswith("The last bin holds all longer ones.")
