import numpy as np
import pytest

from einschalt.foundations.errors import SettingsError
from einschalt.pipeline.simulation.noise import (
    BlockNoise,
    deform_models,
    measure_in_image_plane,
    strain_network,
)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"low_m_g_um": -5}, r"low_m_g_um = -5; expected 0 to 1000 micrometres in the"),
        (
            {"control_standard_error": 30.0},
            r"0 to 10 metres\. Did you give millimetres",
        ),
        ({"high_gross_error_share": 2}, r"high_gross_error_share = 2.*per cent\?"),
        ({"low_deformation_um": -1}, r"low_deformation_um = -1; expected 0 to 1000"),
        ({"orientation_error": 0.1}, r"0 to 0\.02 radians\. Did you give gon\?"),
        ({"network_strain_wavelength": 6.0}, r"Did you give kilometres\?"),
        ({"y_parallax_um": np.nan}, r"y_parallax_um = nan; expected 0 to 1000"),
    ],
)
def test_wrong_value_is_said(wrong, message):
    with pytest.raises(SettingsError, match=message):
        BlockNoise(**wrong)


def test_each_flight_has_its_part_in_metres():
    noise = BlockNoise(low_gross_error_share=0.01, low_gross_error_um=40.0)
    high, low = noise.of_flight("high_flight"), noise.of_flight("low_flight")
    assert (high.m_g, low.m_g) == pytest.approx((7.5e-6, 5e-6))
    assert (high.gross_error_share, low.gross_error_share) == (0.0, 0.01)
    assert low.gross_error == pytest.approx(40e-6)


def test_film_affinity_stretches_x_against_y():
    noise = BlockNoise(low_m_g_um=0.0, film_affinity=2e-4).of_flight("low_flight")
    measured = measure_in_image_plane(
        np.array([[0.1, 0.1]]), noise, *np.random.default_rng(0).spawn(2)
    )
    np.testing.assert_allclose(measured.values, [[0.10001, 0.09999]], rtol=1e-14)


def test_gross_errors_have_their_size_and_leave_the_other_points_alone():
    xy = np.zeros((10_000, 2))
    share, size = 0.05, 60e-6

    def measured(share):
        noise = BlockNoise(low_gross_error_share=share, low_gross_error_um=60.0)
        streams = np.random.default_rng(7).spawn(2)
        return measure_in_image_plane(xy, noise.of_flight("low_flight"), *streams)

    clean, spoilt = measured(0.0), measured(share)
    shift = np.hypot(*(spoilt.values - clean.values).T)
    assert not clean.is_gross.any()
    np.testing.assert_allclose(shift[spoilt.is_gross], size, rtol=1e-10)
    assert (shift[~spoilt.is_gross] == 0.0).all()
    # binomial count within four standard deviations
    expected, deviation = 500.0, np.sqrt(10_000 * share * (1 - share))
    assert abs(spoilt.is_gross.sum() - expected) < 4 * deviation


def test_more_gross_errors_keep_those_that_were():
    xy = np.zeros((1000, 2))

    def is_gross(share):
        noise = BlockNoise(high_gross_error_share=share).of_flight("high_flight")
        return measure_in_image_plane(
            xy, noise, *np.random.default_rng(1).spawn(2)
        ).is_gross

    assert is_gross(0.10)[is_gross(0.02)].all()


def test_strain_is_a_wave_of_each_coordinate_along_the_other_axis():
    noise = BlockNoise(network_strain=0.05, network_strain_wavelength=6000.0)
    along = np.linspace(0.0, 6000.0, 241)
    position = np.column_stack([along, np.full_like(along, 1234.0)])
    shift = strain_network(position, noise, np.random.default_rng(3))
    # northward: one full wave over one wavelength; eastward: it stays
    assert np.ptp(shift[:, 0]) < 1e-15
    assert shift[:, 1].max() == pytest.approx(0.05 / np.sqrt(2), rel=1e-3)
    assert shift[:, 1].min() == pytest.approx(-0.05 / np.sqrt(2), rel=1e-3)
    assert shift[0, 1] == pytest.approx(shift[-1, 1])
    assert np.hypot(*shift.T).max() <= 0.05


def test_without_amplitude_there_is_no_strain():
    shift = strain_network(np.ones((4, 2)), BlockNoise(), np.random.default_rng(0))
    assert (shift == 0.0).all()


def deformed(size_um, seed=0):
    """A grid that fills a model of 138 x 200 mm, and its displacements."""
    axes = np.linspace(-0.069, 0.069, 21), np.linspace(-0.1, 0.1, 21)
    xy = np.stack(np.meshgrid(*axes), -1).reshape(-1, 2)
    noise = BlockNoise(low_deformation_um=size_um).of_flight("low_flight")
    return xy, deform_models(xy, noise, np.random.default_rng(seed))


@pytest.mark.parametrize("seed", range(5))
def test_deformation_has_its_size_at_the_edge_and_no_affine_part(seed):
    xy, moved = deformed(18.75, seed)
    at_edge = (np.abs(xy) >= [0.069, 0.1]).any(axis=1)
    size = np.sqrt(np.mean((moved[at_edge] ** 2).sum(axis=1)))
    assert size == pytest.approx(18.75e-6, rel=1e-9)
    design = np.column_stack([np.ones(len(xy)), xy])
    affine = np.linalg.lstsq(design, moved)[0]
    np.testing.assert_allclose(design @ affine, 0.0, atol=1e-15)


def test_larger_deformation_is_the_same_enlarged_and_none_is_none():
    _, once = deformed(10.0)
    _, twice = deformed(20.0)
    np.testing.assert_allclose(twice, 2.0 * once, rtol=1e-12)
    assert (deformed(0.0)[1] == 0.0).all()
