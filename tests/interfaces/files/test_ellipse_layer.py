"""Confidence ellipses in the GeoPackage and in the folder of a result."""

import numpy as np
import pandas as pd
import pyogrio
import pytest

from einschalt.foundations.errors import SettingsError
from einschalt.interfaces.files.geopackage import write_geopackage
from einschalt.interfaces.files.result_folder import write_result


def outlines(path):
    meta, _, geometry, fields = pyogrio.raw.read(path, layer="ellipses")
    table = pd.DataFrame(dict(zip(meta["fields"], fields, strict=True)))
    # ring of a WKB polygon: 13 bytes of head, then the vertices
    rings = [np.frombuffer(wkb[13:], dtype="<f8").reshape(-1, 2) for wkb in geometry]
    return table, rings


@pytest.mark.parametrize("scale", [1.0, 2000.0, None])
def test_outlines_are_so_many_times_as_large(tmp_path, good_result, scale):
    path = tmp_path / "block.gpkg"
    write_geopackage(good_result, path, ellipse_scale=scale)
    table, rings = outlines(path)
    ellipses = good_result.ellipses
    assert len(table) == len(ellipses)
    factor = table["exaggeration"].iloc[0]
    assert factor == (scale or factor)
    for ring, row in zip(rings, ellipses.itertuples(), strict=True):
        reach = np.hypot(*(ring - [row.easting, row.northing]).T)
        assert reach.max() == pytest.approx(factor * row.semi_major, rel=1e-6)
        # a vertex every 10°: the minor axis has one
        assert reach.min() == pytest.approx(factor * row.semi_minor, rel=1e-6)
        np.testing.assert_array_equal(ring[0], ring[-1])


def test_without_propagation_the_layer_is_empty(tmp_path, given_approximations_result):
    write_geopackage(given_approximations_result, tmp_path / "block.gpkg")
    table, _ = outlines(tmp_path / "block.gpkg")
    assert table.empty


@pytest.mark.parametrize("scale", [0.0, -1.0, float("nan"), float("inf")])
def test_a_scale_that_draws_nothing(tmp_path, good_result, scale):
    with pytest.raises(SettingsError, match=r"ellipse_scale = .*a positive factor"):
        write_result(good_result, tmp_path / "out", ellipse_scale=scale)
    assert not (tmp_path / "out").exists()


def test_tables_of_an_older_result_do_not_stay(
    tmp_path, good_result, given_approximations_result
):
    write_result(good_result, tmp_path)
    for name in ("error_sources", "neighbours", "ellipses"):
        csv = pd.read_csv(tmp_path / f"{name}.csv", dtype={"point_id": str})
        assert len(csv) == len(getattr(good_result, name))
    write_result(given_approximations_result, tmp_path, overwrite=True)
    left = {path.stem for path in tmp_path.iterdir()}
    assert not left & {"error_sources", "neighbours", "ellipses"}
