"""What disturbs the measurements and the control of a simulated block."""

from dataclasses import dataclass

import numpy as np

from einschalt.foundations.errors import raise_problems
from einschalt.foundations.known_fields import with_known_fields
from einschalt.foundations.units import METRES_PER_UM
from einschalt.foundations.value_ranges import Range, problems_in

UM = "micrometres in the image"
SHARE = Range(
    *(0, 0.5, "of the measurements"),
    likely_slip="Did you give per cent?",
    slips=(0.5, 50),
)
RANGES = {
    "control_standard_error": Range(
        0, 10, "metres", likely_slip="Did you give millimetres?", slips=(10, 10_000)
    ),
    "high_m_g_um": Range(0, 1000, UM),
    "low_m_g_um": Range(0, 1000, UM),
    "film_affinity": Range(-0.01, 0.01),
    "high_deformation_um": Range(0, 1000, UM),
    "low_deformation_um": Range(0, 1000, UM),
    "high_gross_error_share": SHARE,
    "low_gross_error_share": SHARE,
    "high_gross_error_um": Range(0, 100_000, UM),
    "low_gross_error_um": Range(0, 100_000, UM),
    "network_strain": Range(0, 10, "metres"),
    "network_strain_wavelength": Range(
        *(10, 10_000_000, "metres"),
        likely_slip="Did you give kilometres?",
        slips=(0.01, 10),
    ),
    "orientation_error": Range(
        0, 0.02, "radians", likely_slip="Did you give gon?", slips=(0.02, 2)
    ),
    "y_parallax_um": Range(0, 1000, UM),
}


@with_known_fields
@dataclass(frozen=True, kw_only=True)
class BlockNoise:
    """Errors of a simulated block.

    Attributes
    ----------
    control_standard_error : float
        TOTAL standard error of the given coordinates [m]; a height has the same as
        one coordinate.
    high_m_g_um, low_m_g_um : float
        TOTAL error of a measured point in the image plane [µm]; per coordinate it is
        smaller by √2. For images it is the error of an image point.
    film_affinity : float
        Differential scale along the strip against across it: x is stretched by half
        of it, y shortened by half.
    high_deformation_um, low_deformation_um : float
        Displacement at the edge of the models (RMS, total) by a deformation that all
        models of a flight share and no affinity takes up, in the image plane [µm].
    high_gross_error_share, low_gross_error_share : float
        Share of the measured points that have a gross error.
    high_gross_error_um, low_gross_error_um : float
        Size of a gross error in the image plane, its direction being random [µm].
    network_strain : float
        Largest displacement of the given coordinates by a smooth strain [m].
    network_strain_wavelength : float
        [m]
    orientation_error : float
        Standard deviation of the five elements of relative orientation that are still
        in error where parallaxes are simulated [rad].
    y_parallax_um : float
        Standard error of a measured y-parallax there [µm].

    Raises
    ------
    SettingsError, BlockError
        A value lies outside its range.

    Examples
    --------
    >>> BlockNoise(low_gross_error_share=1)
    Traceback (most recent call last):
    einschalt.foundations.errors.SettingsError: low_gross_error_share = 1; \
expected 0 to 0.5 of the measurements. Did you give per cent?
    """

    control_standard_error: float = 0.03
    high_m_g_um: float = 7.5
    low_m_g_um: float = 5.0
    film_affinity: float = 0.0
    high_deformation_um: float = 0.0
    low_deformation_um: float = 0.0
    high_gross_error_share: float = 0.0
    low_gross_error_share: float = 0.0
    high_gross_error_um: float = 50.0
    low_gross_error_um: float = 50.0
    network_strain: float = 0.0
    network_strain_wavelength: float = 6000.0
    orientation_error: float = 0.001
    y_parallax_um: float = 5.0

    def __post_init__(self):
        """Check every value."""
        raise_problems(problems_in(self, RANGES))

    def of_flight(self, flight: str) -> "FlightNoise":
        """Return the part that concerns one flight."""
        height = flight.removesuffix("_flight")
        return FlightNoise(
            m_g=METRES_PER_UM * getattr(self, f"{height}_m_g_um"),
            film_affinity=self.film_affinity,
            deformation=METRES_PER_UM * getattr(self, f"{height}_deformation_um"),
            gross_error_share=getattr(self, f"{height}_gross_error_share"),
            gross_error=METRES_PER_UM * getattr(self, f"{height}_gross_error_um"),
            orientation_error=self.orientation_error,
            y_parallax=METRES_PER_UM * self.y_parallax_um,
        )


@dataclass(frozen=True, kw_only=True)
class FlightNoise:
    """Errors as of :class:`BlockNoise`, in metres in the image plane and radians."""

    m_g: float  # TOTAL
    film_affinity: float
    deformation: float
    gross_error_share: float
    gross_error: float
    orientation_error: float
    y_parallax: float


@dataclass(frozen=True, eq=False)
class Disturbed:
    """Measured coordinates, and which of them have a gross error."""

    values: np.ndarray  # (n, 2) [m]
    is_gross: np.ndarray  # (n,)


def measure_in_image_plane(xy, noise, rng, gross_rng, enlarged=1.0) -> Disturbed:
    """Disturb plane coordinates: film, measuring noise, gross errors.

    ``xy`` (n, 2) are the true coordinates along and across the strip, image plane [m].
    Two generators, so that gross errors do not change the noise of the other points.
    Errors are ``enlarged`` so many times, a number or (n,).
    """
    times = np.reshape(enlarged, (-1, 1))
    film = 1.0 + noise.film_affinity * np.array([0.5, -0.5])
    drawn = noise.m_g / np.sqrt(2.0) * rng.standard_normal(xy.shape)
    measured = xy * film + times * drawn
    is_gross = gross_rng.random(len(xy)) < noise.gross_error_share
    direction = gross_rng.uniform(0.0, 2.0 * np.pi, len(xy))
    towards = np.column_stack([np.cos(direction), np.sin(direction)])
    blunder = times * noise.gross_error * towards
    return Disturbed(measured + np.where(is_gross[:, None], blunder, 0.0), is_gross)


DEGREES = {2: 1.0, 3: 0.5, 4: 0.25}
"""Degrees of the polynomials of a deformation, and how large their terms are."""


def deform_models(xy, noise, rng):
    """Displace points by a smooth deformation that all models of a flight share.

    ``xy`` (n, 2) from the centre of the model and displacements (n, 2), image plane
    [m]: polynomials of degree 2 to 4, whose shape ``rng`` draws, without the part that
    an affine transformation takes up.
    """
    powers = [(d - k, k, size) for d, size in DEGREES.items() for k in range(d + 1)]
    sizes = np.array([size for *_, size in powers])
    shape = sizes[:, None] * rng.standard_normal((len(powers), 2))
    if noise.deformation == 0.0 or len(xy) == 0:
        return np.zeros_like(xy)

    def terms(position):
        u, v = position.T
        return np.column_stack([u**p * v**q for p, q, _ in powers])

    axis = np.linspace(-1.0, 1.0, 21)
    grid = np.stack(np.meshgrid(axis, axis), -1).reshape(-1, 2)
    bent = terms(grid) @ shape
    affine = np.linalg.lstsq(np.column_stack([np.ones(len(grid)), grid]), bent)[0]
    bent = bent - affine[0] - grid @ affine[1:]
    at_edge = np.abs(grid).max(axis=1) == 1.0
    size = noise.deformation / np.sqrt(np.mean((bent[at_edge] ** 2).sum(axis=1)))
    position = xy / np.abs(xy).max(axis=0)
    return size * (terms(position) @ shape - affine[0] - position @ affine[1:])


def strain_network(position, noise, rng):
    """Displace given coordinates by a smooth strain.

    Each coordinate is displaced by a wave along the other axis:
    dE = a/√2 sin(2π N/λ + φ), dN likewise with E, a being the largest displacement.

    Each coordinate of ``position`` (n, 2), from the centre of the area [m], is
    displaced by a wave along the other axis: dE = a/√2 sin(2π N/λ + φ), dN likewise
    with E, a being the largest displacement.
    """
    phase = rng.uniform(0.0, 2.0 * np.pi, 2)
    wave = 2.0 * np.pi * position[:, ::-1] / noise.network_strain_wavelength
    return noise.network_strain / np.sqrt(2.0) * np.sin(wave + phase)
