"""Tables of planned precision: columns, warnings, and what is refused."""

import subprocess
import sys
import time

import numpy as np
import pandas as pd
import pytest

import einschalt as es
from einschalt.foundations.errors import GeometryError, SettingsError
from einschalt.pipeline.planning.flights import arguments, cameras

COLUMNS = [
    *("scale_number", "spacing", "m_0", "m_g_um", "flying_height", "n_points"),
    *("m_g_ground", "m_t_centre", "m_t_edge", "M_centre", "M_edge", "M_double"),
]
PAPER = ([6000, 8000], [200, 300], 0.1, (5, 10))


def test_the_table_is_the_product_of_its_arguments():
    table = es.plan_precision(*PAPER)
    assert list(table) == COLUMNS
    given = table[["scale_number", "spacing", "m_0", "m_g_um"]].to_numpy()
    assert given.tolist() == [
        [scale, spacing, 0.1, m_g]
        for scale in (6000, 8000)
        for spacing in (200, 300)
        for m_g in (5, 10)
    ]
    assert (table["flying_height"] == 0.152 * table["scale_number"]).all()


@pytest.mark.parametrize(
    "values",
    [[6000, 8000], (6000.0, 8000.0), np.array([6000, 8000]), pd.Series([6000, 8000])],
    ids=lambda values: type(values).__name__,
)
def test_any_sequence_will_do(values):
    assert len(es.plan_precision(values, 300, 0.1, 10)) == 2


def test_arguments_of_the_camera_count():
    square = es.plan_precision(*PAPER, image_format=0.2, principal_distance=0.1)
    assert square["flying_height"].iloc[0] == pytest.approx(600.0)
    n = 0.6 * 0.2 * 0.7 * 0.2 * (6000 / 200) ** 2
    assert square["n_points"].iloc[0] == pytest.approx(n)
    sides = es.plan_precision(*PAPER, image_format=(0.1, 0.2), edge="corner")
    assert sides["n_points"].iloc[0] == pytest.approx(0.06 * 0.2 * 900)
    overlaps = es.plan_precision(*PAPER, forward_overlap=0.8, side_overlap=0.6)
    n = 0.8 * 0.23 * 0.4 * 0.23 * 900
    assert overlaps["n_points"].iloc[0] == pytest.approx(n)


def test_few_points_are_said_with_what_a_lattice_gives():
    table = es.plan_precision([6000, 12000], [200, 400], 0.1, 10)
    (said,) = table.attrs["warnings"]
    assert "1 of 4 combinations" in said
    assert "5.0 (1:6000, 400 m)" in said
    assert "0.89 m_0; points on a lattice give 1.1 m_0" in said
    lattice = es.plan_precision(6000, 400, 0.1, 10, edge="lattice")
    assert "happen to lie" in lattice.attrs["warnings"][0]
    assert es.plan_precision(8000, 200, 0.1, 10).attrs["warnings"] == []


def test_a_lattice_that_determines_nothing_is_infinite():
    table = es.plan_precision(6000, 500, 0.1, 10, edge="lattice")
    assert np.isinf(table["M_edge"]).all()
    said = es.plan_precision(6000, 500, 0.1, 10, edge="corner").attrs["warnings"]
    assert "may not even determine the transformation" in said[0]


def test_gaps_are_said():
    table = es.plan_precision(8000, 200, 0.1, 10, forward_overlap=0.4)
    assert "gaps" in table.attrs["warnings"][0]


def test_optimal_scale_is_a_row_of_the_table():
    best = es.optimal_scale([300, 400], 0.1, 10, edge="corner")
    for row in best.itertuples():
        table = es.plan_precision(row.scale_number, row.spacing, 0.1, 10, edge="corner")
        assert table["M_edge"].iloc[0] == pytest.approx(row.M_edge, rel=1e-12)
    assert "best scales leave fewer than 12" in best.attrs["warnings"][0]
    assert es.optimal_scale(200, 0.2, 5).attrs["warnings"] == []


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"scale_number": -8000}, r"scale_number = -8000; [^.]*\.$"),
        ({"scale_number": 1 / 8000}, r"0\.000125; .*denominator"),
        ({"scale_number": []}, "scale_number is empty"),
        ({"scale_number": "8000"}, r"scale_number = '8000'"),
        ({"scale_number": "1:8000"}, "'1:8000'; .* Give the denominator: 8000 for"),
        ({"scale_number": True}, "scale_number = True"),
        ({"spacing": 0}, r"spacing = 0; expected 0\.5 to 50000 metres\.$"),
        ({"spacing": 0.25}, r"spacing = 0\.25; .*kilometres"),
        ({"spacing": [300, np.nan]}, "spacing = nan"),
        ({"m_0": 10}, r"m_0 = 10; .*10 cm are 0\.10"),
        ({"m_0": None}, "m_0 = None"),
        ({"m_g_um": 1e-5}, r"m_g_um = 1e-05; .*metres or millimetres"),
        ({"m_g_um": np.inf}, "m_g_um = inf"),
        ({"forward_overlap": 60}, "forward_overlap = 60; .*per cent"),
        ({"forward_overlap": 0}, "forward_overlap = 0"),
        ({"side_overlap": -0.1}, r"side_overlap = -0\.1"),
        ({"side_overlap": 30}, "side_overlap = 30; .*per cent"),
        ({"image_format": 230}, "image_format = 230; .*millimetres"),
        ({"image_format": (0.1, 0.2, 0.3)}, "image_format has 3 values"),
        ({"principal_distance": 152}, "principal_distance = 152; .*millimetres"),
        ({"principal_distance": [0.1, 0.2]}, r"principal_distance = \[0\.1, 0\.2\]"),
        ({"kind": "afine"}, "kind = 'afine' is unknown; .*Write kind=\"affine\""),
        ({"edge": "centre"}, "edge = 'centre'"),
    ],
)
def test_nonsense_is_refused_with_the_remedy(change, says):
    arguments = {"scale_number": 8000, "spacing": 300, "m_0": 0.1, "m_g_um": 10}
    with pytest.raises(SettingsError, match=says):
        es.plan_precision(**{**arguments, **change})


def test_a_spacing_larger_than_the_model_is_refused():
    with pytest.raises(GeometryError, match="larger than a model at 1:6000, 828 x 966"):
        es.plan_precision([6000, 8000], [300, 900], 0.1, 10)
    with pytest.raises(
        GeometryError, match=r"1\.2 points .*at least 3 for kind = affine"
    ):
        es.plan_precision(6000, 800, 0.1, 10)


def test_a_table_that_no_memory_holds_is_refused():
    many = np.linspace(100, 200, 5000)
    with pytest.raises(SettingsError, match="25000000 combinations"):
        es.plan_precision(8000, many, np.linspace(0.1, 0.2, 5000), 10)


def test_a_million_combinations_come_quickly():
    scales, spacings = np.linspace(6000, 15000, 100), np.linspace(100, 400, 100)
    m_0, m_g = np.linspace(0.05, 0.2, 10), np.linspace(3, 15, 10)
    for edge in ("kovarik", "lattice"):
        started = time.process_time()
        table = es.plan_precision(scales, spacings, m_0, m_g, edge=edge)
        assert len(table) == 1_000_000
        assert time.process_time() - started < 2.0


@pytest.mark.slow
def test_planning_imports_neither_numba_nor_scipy():
    code = (
        "import sys, einschalt as es; es.plan_precision(8000, 300, 0.1, 10);"
        "es.optimal_scale(300, 0.1, 10, edge='lattice');"
        "print({'numba', 'scipy', 'matplotlib'} & set(sys.modules))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == "set()"


@pytest.mark.parametrize("camera", cameras.CAMERAS.values(), ids=lambda c: c.title)
def test_camera_presets_are_what_planning_takes(camera):
    table = es.plan_precision(
        camera.scale_numbers,
        camera.spacings,
        camera.m_0,
        camera.m_g_um,
        image_format=camera.image_format,
        principal_distance=camera.principal_distance,
        forward_overlap=camera.forward_overlap,
        side_overlap=camera.side_overlap,
    )
    assert np.isfinite(table.to_numpy()).all()


def test_ranges_name_arguments():
    import inspect

    names = set(inspect.signature(es.plan_precision).parameters)
    assert set(arguments.RANGES) - names == {"target"}


def test_numbers_of_any_kind():
    one = es.plan_precision(8000, np.array(300), 0.1, np.float32(10))
    same = es.plan_precision(8000, 300, 0.1, 10)
    assert one["M_edge"].to_list() == same["M_edge"].to_list()
    with pytest.raises(SettingsError, match="a whole number of 1329 bits"):
        es.plan_precision(8000, 300, 0.1, 10**400)
