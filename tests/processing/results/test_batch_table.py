"""A batch as a table: the same in CSV and parquet, one set of columns, worst first."""

import csv

from pyarrow import parquet

from orbitscan.processing.results.batch_table import Row, tabulate, worst_first, write_table
from orbitscan.processing.results.status import METHODS
from tests.processing.review.batch.test_recording import ROWS, row


def test_worst_first_is_what_failed_then_failed_views_then_errors():
    assert [found.session for found in worst_first(ROWS)] == ["bad", "worst", "worse", "fine"]
    unfinished = Row("a", "unfinished", "later")
    assert [found.session for found in worst_first([ROWS[0], unfinished, ROWS[3]])] == ["bad", "a", "fine"]


def test_recordings_of_other_methods_have_the_same_columns():
    records = tabulate([row("one", 1e-3, methods=("icp",)), row("two", 1e-3, methods=METHODS), ROWS[3]])
    assert len({tuple(record) for record in records}) == 1
    assert records[0]["refined_failed_views"] is None
    assert records[1]["refined_max_center_error_m"] == 2.5e-4
    assert (records[2]["status"], records[2]["problem"]) == ("failed", "bad: cut | off; mend it")


def test_csv_and_parquet_hold_the_same(tmp_path):
    write_table(tmp_path, ROWS)
    table = parquet.read_table(tmp_path / "summary.parquet")
    with (tmp_path / "summary.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    assert list(rows[0]) == table.column_names
    for text, record in zip(rows, table.to_pylist(), strict=True):
        assert text == {name: "" if value is None else str(value) for name, value in record.items()}
    assert str(table.schema.field("icp_failed_views").type) == "int64"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["summary.csv", "summary.parquet"]
