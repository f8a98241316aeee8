"""What is said of flights: how models were moved as the map is."""

from types import SimpleNamespace

import pytest

from einschalt.pipeline.summary.sections.flights import curvature_remark


@pytest.mark.parametrize(
    ("kind", "said"),
    [("helmert_3d", "corrected for Earth curvature"), ("affine", "scale of the map")],
)
def test_models_that_were_bent_are_said(kind, said):
    bent = SimpleNamespace(transformation=kind, is_curved=True)
    flat = SimpleNamespace(transformation=kind, is_curved=False)
    (line,) = curvature_remark((flat, bent))
    assert said in line
    assert not curvature_remark((flat, flat))
