"""Confidence ellipses against eigenvalues and against draws."""

import numpy as np
import pytest
from scipy.stats import chi2

from einschalt.theory.adjustment.ellipses import (
    Ellipses,
    confidence_ellipses,
    ellipse_outlines,
)


def covariances(n):
    root = np.random.default_rng(0).standard_normal((n, 2, 2))
    return root @ np.swapaxes(root, 1, 2)


@pytest.mark.parametrize("level", [0.1, 0.393, 0.95, 0.999])
def test_axes_are_those_of_the_eigenvalues(level):
    covariance = covariances(50)
    found = confidence_ellipses(covariance, level)
    values, vectors = np.linalg.eigh(covariance)
    factor = np.sqrt(chi2.ppf(level, 2))
    np.testing.assert_allclose(found.semi_minor, factor * np.sqrt(values[:, 0]))
    np.testing.assert_allclose(found.semi_major, factor * np.sqrt(values[:, 1]))
    major = vectors[:, :, 1]
    along = np.sin(found.azimuth) * major[:, 0] + np.cos(found.azimuth) * major[:, 1]
    np.testing.assert_allclose(np.abs(along), 1.0)
    assert ((found.azimuth >= 0.0) & (found.azimuth < np.pi)).all()


def test_they_hold_what_they_say():
    covariance = np.array([[4.0, -1.5], [-1.5, 1.0]])
    drawn = np.random.default_rng(1).multivariate_normal([0, 0], covariance, 200_000)
    (found,) = zip(*confidence_ellipses(covariance[None], 0.95), strict=True)
    major, minor, azimuth = found
    along = drawn @ [np.sin(azimuth), np.cos(azimuth)]
    across = drawn @ [np.cos(azimuth), -np.sin(azimuth)]
    inside = (along / major) ** 2 + (across / minor) ** 2 < 1.0
    assert inside.mean() == pytest.approx(0.95, abs=3 * np.sqrt(0.05 * 0.95 / 2e5))


def test_points_without_error_have_no_extent():
    found = confidence_ellipses(np.zeros((1, 2, 2)), 0.95)
    assert [float(part[0]) for part in found] == [0.0, 0.0, 0.0]
    nearly = np.array([[[1.0, 1.0 + 1e-16], [1.0 + 1e-16, 1.0]]])
    assert confidence_ellipses(nearly, 0.95).semi_minor[0] == 0.0


def test_outlines_lie_on_the_ellipse_and_run_anticlockwise():
    covariance = covariances(4)
    centres = np.random.default_rng(2).random((4, 2)) * 1e5
    outlines = ellipse_outlines(centres, confidence_ellipses(covariance, 0.95))
    offset = outlines - centres[:, None]
    inverse = np.linalg.inv(covariance)
    squares = np.einsum("nvi,nij,nvj->nv", offset, inverse, offset)
    np.testing.assert_allclose(squares, chi2.ppf(0.95, 2), rtol=1e-9)
    ahead = np.roll(offset, -1, axis=1)
    area = offset[..., 0] * ahead[..., 1] - offset[..., 1] * ahead[..., 0]
    assert (area > 0.0).all()


def test_an_ellipse_to_the_north():
    ellipse = Ellipses(np.array([2.0]), np.array([1.0]), np.array([0.0]))
    outline = ellipse_outlines(np.zeros((1, 2)), ellipse, 4)[0]
    expected = [[0.0, 2.0], [-1.0, 0.0], [0.0, -2.0], [1.0, 0.0]]
    np.testing.assert_allclose(outline, expected, atol=1e-15)
