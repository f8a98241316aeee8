"""The table of a batch, and what moved between two runs."""

import numpy as np
import pandas as pd
import pytest

from einschalt.foundations.errors import BlockError, FileError, GeometryError
from einschalt.pipeline.batch.block_table import (
    COLUMNS,
    Expectation,
    blocks_table,
    compare_points,
    largest_move_of,
    row_of_failure,
    row_of_figures,
    summarize_batch,
)


def points(**changes):
    table = pd.DataFrame(
        {
            "point_id": ["1", "2", "3"],
            "easting": [100.0, 200.0, 300.0],
            "northing": [10.0, 20.0, 30.0],
            "standard_error_total": [0.05, 0.05, np.nan],
            "standard_error_paper": [0.03, 0.03, 0.02],
        }
    )
    return table.assign(**changes)


def test_points_that_moved_by_more_than_they_claim():
    before = points()
    after = points(easting=[100.03, 200.04, 300.0], northing=[9.96, 20.03, 30.02001])
    # 0.05 and 0.05 are not more than 0.05; 0.02001 is more than the paper's 0.02
    changes = compare_points(after.round(5), before)
    assert changes["point_id"].tolist() == ["3"]
    assert changes["change"].tolist() == ["moved"]
    assert changes["moved_total"][0] == pytest.approx(0.02001, abs=1e-9)


def test_the_largest_move_is_that_of_any_point():
    """It was empty for points that had moved, but none beyond its standard error."""
    after = points(easting=[100.0073, 200.0, 300.0])
    assert compare_points(after, points()).empty
    assert largest_move_of(after, points()) == pytest.approx(0.0073, abs=1e-9)
    assert largest_move_of(points(), points()) == 0.0
    assert np.isnan(largest_move_of(after.iloc[:1], points().iloc[1:]))


def test_points_that_came_and_went():
    changes = compare_points(points().iloc[1:], points().iloc[:2])
    assert changes[["point_id", "change"]].to_numpy().tolist() == [
        ["1", "gone"],
        ["3", "new"],
    ]
    assert changes["easting"].tolist() == [100.0, 300.0]


def test_heights_count_where_they_have_an_error():
    before = points(height=[1.0, 2.0, 3.0])
    after = points(height=[1.0, 2.5, 3.0], standard_error_height=0.1)
    assert compare_points(after, before)["point_id"].tolist() == ["2"]
    assert compare_points(points(height=9.0), before).empty


def test_an_earlier_claim_is_not_that_of_the_present_points():
    before = points()
    unknown = ["standard_error_total", "standard_error_paper"]
    changes = compare_points(points(easting=[101.0, 200.0, 300.0]), before)
    assert changes["standard_error_total"].tolist() == [0.05]
    after = points(easting=[101.0, 200.0, 300.0]).drop(columns=unknown).iloc[1:]
    changes = compare_points(after, before)
    assert changes["change"].tolist() == ["gone"]
    assert changes["standard_error_total"].isna().all()


def test_points_that_claim_nothing_move_by_a_millimetre():
    unknown = ["standard_error_total", "standard_error_paper"]
    before = points(height=5.0).drop(columns=unknown)
    after = points(easting=[200.0, 200.0009, 300.0], northing=[10.0, 20.0, 30.0011])
    after = after.drop(columns=unknown).assign(height=[5.0, 5.0, 5.0])
    assert compare_points(after, before)["point_id"].tolist() == ["1", "3"]
    after = before.assign(height=[5.0, 5.01, 5.0], standard_error_height=np.nan)
    assert compare_points(after, before)["point_id"].tolist() == ["2"]


def test_comparison_against_a_loop():
    rng = np.random.default_rng(0)
    n = 500
    before = pd.DataFrame(
        {
            "point_id": [f"{k}" for k in range(n)],
            "easting": rng.uniform(0, 1e4, n),
            "northing": rng.uniform(0, 1e4, n),
            "standard_error_total": rng.uniform(0.02, 0.08, n),
        }
    )
    after = before.sample(frac=1.0, random_state=1).reset_index(drop=True)
    after["easting"] += rng.normal(0, 0.05, n)
    expected = {
        row.point_id
        for row in after.itertuples()
        if abs(row.easting - before.easting[int(row.point_id)])
        > row.standard_error_total
    }
    assert 50 < len(expected) < 450
    assert set(compare_points(after, before)["point_id"]) == expected


FIGURES = {
    "n_points": 80,
    "mean_total": 0.052,
    "mean_paper": 0.036,
    "mean_internal": None,
    "n_suspects": 2,
    "n_failed": 1,
}


def test_table_has_its_columns_and_kinds():
    done = row_of_figures(
        "north", "done", FIGURES, 1.5, compare_points(*[points()] * 2)
    )
    failed = row_of_failure("south", FileError("is gone", file="a.csv"), "reading")
    table = blocks_table([done, failed])
    assert tuple(table) == COLUMNS
    assert table["n_points"].tolist() == [80, pd.NA]
    assert table["n_moved"].tolist() == [0, pd.NA]
    assert np.isnan(table["standard_error_internal"]).all()
    assert table["reason"].tolist() == ["", "a.csv: is gone"]
    assert blocks_table([]).columns.tolist() == list(COLUMNS)


def test_reason_and_remedy_of_errors():
    problems = [FileError(f"fault {k}", remedy=f"Mend {k}") for k in range(3)]
    row = row_of_failure("a", BlockError(problems), "reading", 0.5)
    assert row["reason"] == "fault 0 (and 2 more problems: see failure.json)"
    assert row["remedy"] == "Mend 0"
    row = row_of_failure("a", MemoryError(), "stage3_model_transformation")
    assert row["reason"] == "needs more memory than there is"
    assert row["stage"] == "stage3_model_transformation"
    row = row_of_failure("a", GeometryError("no model", stage="stage1"), "stage3")
    assert row["stage"] == "stage1"


def test_expected_end():
    expected = Expectation(total=10.0)
    assert expected.seconds_left(3.0) is None
    expected.done = 2.5
    assert expected.seconds_left(5.0) == 15.0


def test_summary_says_numbers_failures_and_moves():
    moved = compare_points(points(easting=[100.3, 200.0, 300.0]), points())
    rows = [
        row_of_figures("north", "done", FIGURES, 1.5, moved, 0.3),
        row_of_figures("south", "skipped", FIGURES, 1.5),
        *(
            row_of_failure(
                f"bad_{k}", FileError("is gone", remedy="Find it"), "reading"
            )
            for k in range(12)
        ),
    ]
    lines = summarize_batch(blocks_table(rows), 75.0).splitlines()
    assert lines[0] == "14 blocks: 1 done, 1 skipped, 12 failed (1 min 15 s)"
    assert "  bad_0: is gone." in lines
    assert "    Find it" in lines
    assert "  and 2 more" in lines
    assert lines[-1] == "  north: 1 point, at most 30 cm"


def test_the_figure_to_believe_and_whether_the_claim_stands():
    figures = {"n_points": 4, "credible": 0.2, "claim_is_supported": False}
    of_earlier_version = {"n_points": 4}
    table = blocks_table(
        row_of_figures(name, "done", facts, 1.0)
        for name, facts in (("now", figures), ("then", of_earlier_version))
    )
    assert table["standard_error_credible"].tolist()[0] == 0.2
    assert table["claim_is_supported"].tolist() == [False, None]
    said = summarize_batch(table, 2.0)
    assert "Stated precision not supported: see their reports" in said
    assert "  now: 20 cm or worse (total)" in said
    assert "then" not in said
