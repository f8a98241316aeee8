"""Which models of an area are flown: as every footprint cut with it would tell."""

import numpy as np
import pytest
import shapely
from tests.truth.long_form.area_plans import star_shaped

from einschalt.pipeline.planning.area.layout import (
    LEAST_SHARE,
    LEFT_OVER,
    models_worth_flying,
)


def _worth_flying(shape, centres, half):
    """The rule as it is written, of every footprint by itself."""
    footprints = shapely.box(*(centres - half).T, *(centres + half).T)
    whole = float(np.prod(2.0 * half))
    share = shapely.area(shapely.intersection(shape, footprints)) / whole
    kept = share >= LEAST_SHARE
    small = np.flatnonzero(~kept & (share > 0.0))
    left = shapely.difference(
        shapely.union_all(shapely.intersection(shape, footprints[small])),
        shapely.union_all(footprints[kept]),
    )
    for place in small[np.argsort(-share[small], kind="stable")]:
        if left.area <= LEFT_OVER * whole:
            break
        rest = shapely.difference(left, footprints[place])
        if left.area - rest.area > LEFT_OVER * whole:
            kept[place], left = True, rest
    return np.flatnonzero(kept)


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("overlap", [0.3, 0.8])
def test_the_models_are_those_of_every_footprint_cut(seed, overlap):
    rng = np.random.default_rng(seed)
    shape = star_shaped(rng, 2000.0).local_shape
    if seed % 2:  # a lake that is left out
        shape = shape.difference(shapely.Point(50.0, 20.0).buffer(250.0))
    half = np.array([60.0, 110.0])
    apart = 2.0 * half * [1.0 - overlap, 0.7]
    along, across = (np.arange(-1100.0, 1101.0, step) for step in apart)
    centres = np.stack(np.meshgrid(along, across), axis=-1).reshape(-1, 2)
    kept = models_worth_flying(shape, centres, half)
    assert 30 < len(kept) < len(centres)
    np.testing.assert_array_equal(kept, _worth_flying(shape, centres, half))


def test_an_area_that_only_small_parts_of_models_hold():
    half = np.array([500.0, 500.0])
    shape = shapely.box(-50.0, -50.0, 50.0, 50.0)
    centres = np.array([[-520.0, 0.0], [520.0, 0.0], [0.0, 30.0]])
    np.testing.assert_array_equal(models_worth_flying(shape, centres, half), [2])
