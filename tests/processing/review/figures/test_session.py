"""Figures show the numbers of results.json, mark what failed, and are the same bytes each time."""

from dataclasses import replace

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg

from orbitscan.processing.results.estimates import MethodResult, ViewErrors
from orbitscan.processing.results.folder import Results, write_results
from orbitscan.processing.results.status import METHODS, Method
from orbitscan.processing.review.entities import METHOD_COLORS
from orbitscan.processing.review.figures import session
from orbitscan.recorder.exceptions import UnwritableOutput
from tests.processing.review.made_results import EMPTY, FAILED, make_results

KEY = {"input_sha256": ""}


def results_of(**options):
    return Results.of(make_results(**options)[1], KEY, "bumpy_sphere.mcap", None)


def curves(axes):
    """The curves of a plot by the colour of their method."""
    colors = {tuple(c / 255 for c in rgb): method for method, rgb in METHOD_COLORS.items()}
    return {colors[line.get_color()]: line for line in axes.lines if line.get_linestyle() != "None"}


def marks(axes, marker):
    return [tuple(line.get_xydata()[0]) for line in axes.lines if line.get_marker() == marker and len(line.get_xdata())]


def test_a_curve_has_the_errors_of_its_method_in_millimetres():
    results = results_of()
    figure = session.draw_session(results)["errors"]
    translation, chordal, center = figure.axes
    for axes, name, factor in ((translation, "translation_error_m", 1e3), (chordal, "rotation_error_chordal", 1)):
        assert list(curves(axes)) == list(METHODS)
        for method, line in curves(axes).items():
            known = [getattr(view.errors, name) for view in results.reconstruction[method].views]
            expected = [np.nan if not value else factor * value for value in known]  # view 0 has no logarithm
            np.testing.assert_allclose(line.get_ydata(), expected)
            assert list(line.get_xdata()) == [0, 1, 2, 3, 4]
    assert [axes.get_yscale() for axes in figure.axes] == ["log"] * 3
    assert "[mm]" in translation.get_ylabel()
    assert "[mm]" in center.get_ylabel()
    assert "2.83" in chordal.get_ylabel()


def test_methods_that_differ_little_share_a_linear_axis():
    results = results_of()
    results = replace(results, reconstruction={Method.PAIRWISE: results.reconstruction[Method.PAIRWISE]})
    (axes, *_) = session.draw_session(results)["errors"].axes
    assert axes.get_yscale() == "linear"
    assert axes.get_ylim()[0] == 0
    assert curves(axes)["pairwise"].get_ydata()[0] == 0


def test_methods_are_told_apart_without_colour():
    figure = session.draw_session(results_of())["errors"]
    lines = curves(figure.axes[0]).values()
    assert len({line.get_marker() for line in lines}) == 4
    assert len({str(line._dash_pattern) for line in lines}) == 4


def test_views_that_failed_are_marked_and_told_in_the_legend():
    results = results_of()
    figure = session.draw_session(results)["errors"]
    axes = figure.axes[0]
    of_failed = {m: 1e3 * results.reconstruction[m].views[FAILED].errors.translation_error_m for m in METHODS}
    assert marks(axes, "+") == [(FAILED, pytest.approx(of_failed["refined"]))]
    crosses = [place for place in marks(axes, "x") if place[1] > 0]
    assert crosses == [(FAILED, pytest.approx(of_failed[m])) for m in METHODS[:3]]
    on_axis = [place for place in marks(axes, "x") if place[1] == 0]
    assert [round(x) for x, _ in on_axis] == [EMPTY] * 4
    assert len({x for x, _ in on_axis}) == 4
    names = [text.get_text() for text in figure.legends[0].get_texts()]
    assert names == [*METHODS, "ambiguous", "failed", "no pose, on the axis"]


def test_without_truth_the_evidence_of_the_pairs_is_drawn():
    results = results_of(with_truth=False)
    drawn = session.draw_session(results)
    assert list(drawn) == ["evidence"]
    overlap, residual, confidence = drawn["evidence"].axes
    np.testing.assert_allclose(curves(overlap)["pairwise"].get_ydata(), [np.nan, 0.8, 0.6, 0.4, np.nan])
    np.testing.assert_allclose(curves(residual)["icp"].get_ydata(), [np.nan, 1.0, 2.0, 3.0, np.nan])
    # of the two pairs of view 2, the one that the others do not contradict
    np.testing.assert_allclose(curves(confidence)["refined"].get_ydata(), [np.nan, 0.9, 0.9, 0.9, np.nan])
    assert overlap.get_ylim()[1] == confidence.get_ylim()[1] == 1.05
    assert "no ground truth" in drawn["evidence"].get_suptitle()


def test_nothing_is_drawn_of_nothing():
    results = results_of(with_truth=False)
    alone = {method: MethodResult(found.views[:1], ()) for method, found in results.reconstruction.items()}
    assert session.draw_session(replace(results, reconstruction=alone)) == {}


def test_only_some_views_have_a_truth():
    results = results_of()
    for method, found in results.reconstruction.items():
        unknown = replace(found.views[2], errors=ViewErrors())
        views = (*found.views[:2], unknown, *found.views[3:])
        results.reconstruction[method] = replace(found, views=views)
    line = curves(session.draw_session(results)["errors"].axes[0])["icp"]
    assert np.isnan(line.get_ydata()[2])


@pytest.fixture
def folder(tmp_path):
    write_results(tmp_path, make_results()[1], results_of(), {})
    return tmp_path


def test_files_are_written_whole_and_the_same_each_time(folder):
    paths = session.write_figures(folder)
    assert [path.relative_to(folder).as_posix() for path in paths] == ["figures/errors.png", "figures/errors.svg"]
    first = [path.read_bytes() for path in paths]
    session.write_figures(folder)
    assert [path.read_bytes() for path in paths] == first
    assert sorted(path.name for path in (folder / "figures").iterdir()) == ["errors.png", "errors.svg"]
    assert first[0].startswith(b"\x89PNG")
    assert b"dc:date" not in first[1]
    assert b"ransac_icp" in first[1]  # words stay words


def test_an_unwritable_place_is_told_in_a_sentence(folder):
    (folder / "figures").write_text("in the way")
    with pytest.raises(UnwritableOutput, match="cannot be written"):
        session.write_figures(folder)


def test_nothing_is_cut_off():
    figure = session.draw_session(results_of())["errors"]
    FigureCanvasAgg(figure).draw()
    (legend,) = figure.legends
    box = legend.get_window_extent()
    assert box.x0 >= 0
    assert box.x1 <= figure.bbox.x1
