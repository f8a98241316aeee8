"""Observed coordinates of GNU Gama: groups, axes, points that are fixed."""

import numpy as np
import pytest

from einschalt.foundations.errors import EinschaltError
from einschalt.interfaces.programs.recognised import read_foreign

ERRORS = [f"standard_error_{axis}" for axis in ("easting", "northing", "height")]
PLANE = ["easting", "northing"]


def group(points, dim, band, values):
    said = "".join(
        f'<point id="{name}" '
        + " ".join(
            f'{axis}="{value}"' for axis, value in zip("xyz", place, strict=False)
        )
        + "/>"
        for name, *place in points
    )
    matrix = f'<cov-mat dim="{dim}" band="{band}">{values}</cov-mat>'
    return f"<coordinates>{said}{matrix}</coordinates>"


ONE = group([("A", 5200000.5, 450000.25)], 2, 1, "100 50 400")
TWO = group([("B", 1.5, 2.5, 3.5), ("C", 4.5, 5.5)], 5, 0, "1 4 9 16 25")


@pytest.fixture
def read(tmp_path):
    def write(inside, axes='axes-xy="ne"'):
        path = tmp_path / "a.gkf"
        path.write_text(
            f"<gama-local><network {axes}><points-observations>{inside}"
            "</points-observations></network></gama-local>"
        )
        return path

    return write


def table_of(path):
    return read_foreign(path).tables["control_points"].set_index("point_id")


def test_every_group_is_read(read):
    table = table_of(read(ONE + TWO))
    assert table.index.tolist() == ["A", "B", "C"]
    assert table[PLANE].to_numpy().tolist() == [
        [450000.25, 5200000.5],
        [2.5, 1.5],
        [5.5, 4.5],
    ]
    np.testing.assert_equal(table["height"].to_numpy(), [np.nan, 3.5, np.nan])
    # square millimetres: of A easting 400, northing 100; of B 4, 1, 9; of C 25, 16
    expected = [[0.020, 0.010, np.nan], [0.002, 0.001, 0.003], [0.005, 0.004, np.nan]]
    np.testing.assert_allclose(table[ERRORS].to_numpy(), expected)
    np.testing.assert_allclose(table["covariance_en"], [50e-6, 0.0, 0.0])


@pytest.mark.parametrize(
    ("axes", "easting", "northing", "east_mm", "sign", "said"),
    [
        ("ne", 450000.25, 5200000.5, 20, 1, None),
        ("en", 5200000.5, 450000.25, 10, 1, None),
        ("sw", -450000.25, -5200000.5, 20, 1, "south and west"),
        ("ws", -5200000.5, -450000.25, 10, 1, "south and west"),
        ("es", 5200000.5, -450000.25, 10, -1, "south"),
        ("wn", -5200000.5, 450000.25, 10, -1, "west"),
        ("nw", -450000.25, 5200000.5, 20, -1, "west"),
        ("se", 450000.25, -5200000.5, 20, -1, "south"),
    ],
)
def test_axes_are_turned(read, axes, easting, northing, east_mm, sign, said):
    path = read(ONE, f'axes-xy="{axes}"')
    point = table_of(path).loc["A"]
    assert (point["easting"], point["northing"]) == (easting, northing)
    errors = [point[name] * 1e3 for name in ERRORS[:2]]
    np.testing.assert_allclose(errors, [east_mm, 30 - east_mm])
    assert point["covariance_en"] == pytest.approx(sign * 50e-6)
    told = [note for note in read_foreign(path).notes if "axes-xy" in note]
    assert bool(told) == (said is not None)
    assert all(f"axes to the {said}:" in note for note in told)


def test_axes_are_those_of_gama_where_nothing_is_said(read):
    assert table_of(read(ONE, "")).loc["A", "easting"] == 450000.25
    with pytest.raises(EinschaltError, match="axes-xy is 'xy'"):
        read_foreign(read(ONE, 'axes-xy="xy"'))


def test_fixed_points_without_covariance_are_named(read):
    fixed = '<point id="F" x="1" y="2" fix="xy"/><point id="A" x="1" y="2" fix="xy"/>'
    free = '<point id="N" x="1" y="2" adj="xy"/>'
    notes = read_foreign(read(fixed + free + ONE)).notes
    told = [note for note in notes if "fixed" in note]
    assert len(told) == 1
    assert "1 fixed point without a covariance left out: F. Give" in told[0]
