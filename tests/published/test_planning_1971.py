"""Planning tables beside an independent computation of Kovarik's diagrams."""

import itertools
import json
from pathlib import Path

import numpy as np
import pytest

import einschalt as es
from einschalt.theory.planning.leverage import corner_factor, mid_edge_factor

GOLDEN = json.loads(
    (Path(__file__).parent / "cases" / "planning.json").read_text(encoding="utf-8")
)
EDGES = {
    "full_affine_corner": "corner",
    "net70_affine_mid(=paper rule k=2)": "kovarik",
}
COLUMNS = {
    "n": ("n_points", 1.0),
    "hg_m": ("flying_height", 1.0),
    "g_cm": ("m_g_ground", 100.0),
    "mt_centre_cm": ("m_t_centre", 100.0),
    "mt_edge_cm": ("m_t_edge", 100.0),
    "M_centre_cm": ("M_centre", 100.0),
    "M_edge_cm": ("M_edge", 100.0),
    "M_double_cm": ("M_double", 100.0),
}


@pytest.mark.parametrize("name", EDGES)
def test_tables_agree_to_1e_9(name):
    rows = GOLDEN["tables"][name]
    scales, spacings, m_0_cm, m_g_um = (
        sorted({row[key] for row in rows}) for key in ("scale", "s_m", "m0_cm", "mg_um")
    )
    m_0 = [value / 100 for value in m_0_cm]
    table = es.plan_precision(scales, spacings, m_0, m_g_um, edge=EDGES[name])
    product = list(itertools.product(scales, spacings, m_0_cm, m_g_um))
    by_key = {(r["scale"], r["s_m"], r["m0_cm"], r["mg_um"]): r for r in rows}
    assert len(table) == len(product) == len(rows)
    for key, (column, factor) in COLUMNS.items():
        expected = [by_key[place][key] for place in product]
        np.testing.assert_allclose(table[column] * factor, expected, rtol=1e-9)


@pytest.mark.parametrize("kind", ["affine", "helmert", "rigid"])
def test_edge_factors_agree(kind):
    expected = GOLDEN["nh"][kind]
    assert corner_factor(kind) == pytest.approx(expected["corner"], rel=1e-12)
    worse = max(expected["mid_short"], expected["mid_long"])
    assert mid_edge_factor(kind, (0.138, 0.23)) == pytest.approx(worse, rel=1e-12)
