"""The review's curves: equal to the results, complete, at the views' stamps."""

import pytest
from rerun.chunk import RrdReader

from orbitscan.processing.results.status import METHODS, Method
from orbitscan.processing.review import entities
from tests.processing.review.made_results import BOUND_DEG, BOUND_M, FAILED, write_review
from tests.processing.review.recordings import read_rows

ERROR_FIELDS = {
    "translation_m": "translation_error_m",
    "rotation_chordal": "rotation_error_chordal",
    "rotation_deg": "rotation_error_deg",
    "center_m": "center_error_m",
}


def test_error_curves_read_back_equal_the_results(reviewed):
    path, (_, session) = reviewed
    curves = read_rows(path, "/errors/**", "Scalars:scalars")
    in_mm = {quantity: (ERROR_FIELDS[error], 1e3) for quantity, (_, error) in entities.MM_ERRORS.items()}
    quantities = {quantity: (field, 1.0) for quantity, field in ERROR_FIELDS.items()} | in_mm
    assert len(curves) == len(METHODS) * len(quantities)
    for method, found in session.reconstruction.items():
        for quantity, (field, factor) in quantities.items():
            values = {v.view: getattr(v.errors, field) for v in found.views}
            expected = {view: factor * value for view, value in values.items() if value is not None}
            assert {view: cell[0] for view, cell in curves[f"/errors/{quantity}/{method}"].items()} == expected


def test_logarithms_are_of_millimetres_and_leave_the_origin_out(reviewed):
    path, _ = reviewed
    curve = read_rows(path, "/errors_log10/**", "Scalars:scalars")["/errors_log10/translation_mm/icp"]
    assert sorted(curve) == [1, 2, 3]
    assert curve[1][0] == pytest.approx(1.0)  # 10 mm


def test_bounds_stand_beside_the_errors_in_a_lighter_colour(reviewed):
    bounds = read_rows(reviewed[0], "/bounds/**", "Scalars:scalars")
    assert bounds == {
        "/bounds/rotation_deg/refined": {view: [BOUND_DEG * view] for view in range(FAILED)},
        "/bounds/center_m/refined": {view: [BOUND_M * view] for view in range(FAILED)},
        "/bounds/center_mm/refined": {view: [1e3 * BOUND_M * view] for view in range(FAILED)},
    }
    logarithms = read_rows(reviewed[0], "/bounds_log10/**", "Scalars:scalars")
    assert logarithms["/bounds_log10/rotation_deg/refined"] == {1: [pytest.approx(-1)], 2: [pytest.approx(-0.69897)]}
    color, name, _ = entities.curve_style("/bounds/center_mm/refined")
    assert name == "refined, 95 % bound"
    assert all(light > plain for light, plain in zip(color, Method.REFINED.color, strict=True))


def test_without_truth_there_are_bounds(tmp_path):
    write_review(tmp_path / "review.rrd", with_truth=False)
    assert "/bounds/rotation_deg/refined" in read_rows(tmp_path / "review.rrd", "/bounds/**", "Scalars:scalars")


def test_evidence_and_timing_are_there(reviewed):
    path, _ = reviewed
    evidence = read_rows(path, "/evidence/**", "Scalars:scalars")
    assert evidence["/evidence/overlap/pairwise"] == {1: [0.8], 2: [0.6], 3: [pytest.approx(0.4)]}
    assert evidence["/evidence/violations/refined"] == {1: [0.01], 2: [0.01], 3: [0.01]}
    assert {path.split("/")[2] for path in evidence} <= set(entities.EVIDENCE)  # each has a title
    assert "/evidence/inliers/icp" not in evidence
    assert read_rows(path, "/timing/**", "Scalars:scalars")["/timing/total/icp"][2] == [0.05]


def test_stamps_are_those_of_the_views(reviewed):
    path, (views, _) = reviewed
    chunks = [c for c in RrdReader(path).stream().filter(content="/errors/**") if not c.is_static]
    for chunk in chunks:
        batch = chunk.to_record_batch()
        assert set(chunk.timeline_names) == {"view", "stamp"}
        stamps = batch.column("stamp").cast("int64").to_pylist()
        assert stamps == [views[view].stamp_ns for view in batch.column("view").to_pylist()]
