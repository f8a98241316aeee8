"""What is not to be used blindly is told before it is used."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

import einschalt as es
from einschalt.foundations.language import written_in
from einschalt.interfaces.publication.doubts import doubts_of
from einschalt.interfaces.publication.operations_of_results import (
    Frames,
    operations_of_block,
)

N_POINTS = 12
OFF = {"3": 0.4, "4": 40.0}  # metres, of one point of a model


def models(n_points, rng):
    """Model points and ground of one model each, 1 km wide, with errors of 2 cm."""
    rows, ground = [], []
    for model, n in n_points.items():
        places = np.array([[0, 0], [1000, 0], [0, 1000], [1000, 1000]], dtype=float)
        places = np.vstack([places, rng.uniform(0.0, 1000.0, (N_POINTS, 2))])[:n]
        names = [f"{model}-{k}" for k in range(n)]
        measured = places + rng.normal(0.0, 0.02, places.shape)
        measured[-1] += OFF.get(model, 0.0)
        rows.append(pd.DataFrame(measured, columns=["x", "y"]))
        rows[-1] = rows[-1].assign(model_id=model, point_id=names)
        ground.append(pd.DataFrame(places, columns=["easting", "northing"]))
        ground[-1] = ground[-1].assign(point_id=names)
    return pd.concat(rows), pd.concat(ground)


@pytest.fixture(scope="module")
def published(tmp_path_factory):
    alike = dict.fromkeys("03456789", N_POINTS)
    given = models({"1": 3} | alike, np.random.default_rng(5))
    folder = tmp_path_factory.mktemp("doubts") / "out"
    return es.transform_models(*given).publish("OLD", folder)


def test_what_misses_held_out_points_by_far_is_told(published):
    assert list(published.operations["n_held_out"]).count(0) == 1
    unchecked, wide, far = published.doubts
    assert unchecked.startswith("1 transformation without a point to spare: OLD_1. No")
    assert wide.startswith(
        "1 transformation misses held-out points by more than 1 % of the extent of "
        "their points: OLD_4, up to "
    )
    assert far.startswith(
        "1 transformation misses held-out points by more than 5 times the median of all"
    )
    assert ": OLD_3, up to 0." in far
    said = " ".join(published.summary().split())
    page = (published.folder / "README.md").read_text("utf-8")
    for doubt in published.doubts:
        assert f"warning: {doubt}" in said
        assert doubt in page
    with written_in("de"):
        assert "Warnung: 1 Transformation ohne überschüssigen" in published.summary()


def test_nothing_is_told_of_what_holds(tmp_path):
    given = models(dict.fromkeys("0125", N_POINTS), np.random.default_rng(6))
    done = es.transform_models(*given).publish("OLD", tmp_path / "out")
    assert done.doubts == ()
    assert "warning" not in done.summary()


def test_models_without_redundancy_have_no_held_out_points(good_result):
    """Rounding in place of their residuals came to an accuracy of 54 km."""
    low = good_result.models.iloc[[-1]].assign(redundancy=0)
    key = ["flight", "coverage", "model_id"]
    own = good_result.residuals.merge(low[key], on=key)
    own = own.assign(residual_easting=1e-9, leverage=1.0 - 1e-14)
    tables = {"models": low, "residuals": own, "points": good_result.points}
    (one,) = operations_of_block(tables, Frames("DEMO", None))
    assert one.n_held_out == 0
    assert one.accuracy_m < 1.0  # of the errors that are propagated


def test_gross_errors_that_were_taken_out_are_not_held_out(good_result):
    """They came to an accuracy of 72 m, in place of 15 cm."""
    low = good_result.models.iloc[[-1]]
    own = good_result.residuals.merge(low[["flight", "coverage", "model_id"]])
    tables = {"models": low, "residuals": own.iloc[1:], "points": good_result.points}
    (expected,) = operations_of_block(tables, Frames("DEMO", None))
    out = own.index == own.index[0]
    own.loc[out, ["residual_easting", "leverage"]] = [70.0, 0.0]
    (one,) = operations_of_block(tables | {"residuals": own}, Frames("DEMO", None))
    assert one.accuracy_m == expected.accuracy_m
    assert one.n_held_out == expected.n_held_out
    assert doubts_of([one]) == ()


def test_doubts_are_of_held_out_points_and_of_what_is_seen(good_result):
    names = ("models", "residuals", "points")
    tables = {name: getattr(good_result, name) for name in names}
    sound = operations_of_block(tables, Frames("DEMO", None))
    assert doubts_of(sound) == ()
    # exact but for rounding, of which one has more
    errors = np.full(len(sound), 1e-12)
    errors[0] = 9e-12
    exact = [replace(o, missed_m=e) for o, e in zip(sound, errors, strict=True)]
    assert doubts_of(exact) == ()
    # much is propagated, and nothing missed
    weak = [replace(sound[0], accuracy_m=500.0), *sound[1:]]
    assert doubts_of(weak) == ()
    off = [replace(sound[0], missed_m=500.0), *sound[1:]]
    assert "up to 500.0000 m" in doubts_of(off)[0]
