"""Deformations of single models as a source of the propagation."""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from einschalt.stages.error_propagation.own_deformation_errors import bending_chains
from einschalt.theory.adjustment.point_operator import Axes
from einschalt.theory.block_adjustment.common_parameters import positions_in_model
from einschalt.theory.block_adjustment.own_deformation import (
    HEIGHT,
    PLAN,
    OwnDeformation,
    bending_terms,
)


@pytest.fixture
def flights():
    rng = np.random.default_rng(4)
    points, fits = {}, {}
    for name, n_models in (("high_flight", 2), ("low_flight", 3)):
        codes = np.repeat(np.arange(n_models), 12)
        xy = rng.uniform(-80.0, 80.0, (len(codes), 2))
        points[name] = pd.DataFrame(xy, columns=["x", "y"])
        fits[name] = SimpleNamespace(
            models=range(n_models),
            observed=SimpleNamespace(models=SimpleNamespace(codes=codes)),
        )
    return points, fits


def own_of(*sizes):
    """Sizes given as flight, family, axis, size."""
    flight, family, axis, size = zip(*sizes, strict=True)
    nothing = np.full(len(size), np.nan)
    return OwnDeformation(np.array(flight), family, axis, np.array(size), nothing, 1e-9)


@pytest.mark.parametrize("axes", [Axes.COMPLEX, Axes.PLANE, Axes.SPACE])
def test_every_model_is_moved_by_its_own_coefficients(flights, axes):
    points, fits = flights
    own = own_of(
        (0, "quadratic", PLAN, 0.0),
        (1, "affinity", PLAN, 0.03),
        (1, "quadratic", PLAN, 0.05),
        (1, "quadratic", HEIGHT, 0.02),
    )
    chain = bending_chains(own, points, fits, axes)["low_flight"]
    n_terms, n_models = 4, 5
    assert chain.n_sources == n_terms * n_models
    rng = np.random.default_rng(1)
    plan = rng.standard_normal((n_models, n_terms, 2)) @ [1.0, 1j]
    height = rng.standard_normal((n_models, n_terms))
    sources = np.stack([plan.real, plan.imag, height], -1).reshape(-1, 3)
    n_coordinates = len(axes.names)
    packed = axes.packed(sources[:, :n_coordinates])
    moved = axes.unpacked(chain.matrix @ packed)
    xy, codes = (
        points["low_flight"].to_numpy(),
        fits["low_flight"].observed.models.codes,
    )
    position, _ = positions_in_model(xy, codes)
    mirrored, bends = (bending_terms(f, position) for f in ("affinity", "quadratic"))
    of_models = plan[2 + codes]  # those of the high flight come first
    expected = 0.03 * mirrored[:, 0] * of_models[:, 0]
    expected = expected + 0.05 * (bends * of_models[:, 1:]).sum(axis=1)
    assert moved[:, 0] == pytest.approx(expected.real)
    assert moved[:, 1] == pytest.approx(expected.imag)
    if axes is Axes.SPACE:
        up = 0.02 * (bends.real * height[2 + codes, 1:]).sum(axis=1)
        assert moved[:, 2] == pytest.approx(up)


def test_without_deformation_there_is_no_source(flights):
    assert bending_chains(None, *flights, Axes.PLANE) == {}
    nothing = own_of((1, "quadratic", PLAN, 0.0))
    assert bending_chains(nothing, *flights, Axes.PLANE) == {}
