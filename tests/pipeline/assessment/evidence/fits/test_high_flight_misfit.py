"""How the high flight should fit where one adjustment has models from images."""

import numpy as np
import pytest

import einschalt as es
from einschalt.pipeline.assessment.examination import examine
from einschalt.pipeline.simulation.simulate_block import BlockGeometry, simulate_block

# models of a short base: their orientations bend them by much
GEOMETRY = BlockGeometry(
    width=2_200.0,
    height=2_200.0,
    point_spacing=275.0,
    measurement="images",
    transformation="helmert_3d",
    control_per_model=9,
    forward_overlap=0.8,
)


def misfit_of(seed):
    block = simulate_block("demo", seed=seed, geometry=GEOMETRY)
    result = es.densify(block, es.Settings(method="simultaneous"))
    found = {finding.code for finding in result.assessment.findings}
    return examine(result.solution).misfit, found


def test_orientations_of_short_bases_are_no_misfit():
    misfit, found = misfit_of(1)
    assert misfit.ratio == pytest.approx(1.0, abs=0.2)
    assert "high_flight_that_misfits" not in found


@pytest.mark.slow
def test_expected_fit_is_that_of_many_blocks():
    """The ratio of each scatters by its degrees of freedom."""
    misfits = [misfit_of(seed)[0] for seed in range(10, 18)]
    squares = np.array([misfit.ratio**2 for misfit in misfits])
    error = np.sqrt(2.0 / np.array([misfit.degrees for misfit in misfits]))
    standardised = (squares - 1.0) / error
    assert abs(standardised.mean()) < 3.0 / np.sqrt(len(squares))
    assert np.abs(standardised).max() < 3.5
