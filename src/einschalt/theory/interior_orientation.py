"""Interior orientation: from what was measured in an image to rays of its camera.

Image coordinates of einschalt have their origin in the principal point, x to the right
and y up [mm]. What users have are pixels, or millimetres from another origin, with
the constants of a calibration in the convention of the program that made it:

opencv
    fx, fy, cx, cy [pixels], k1, k2, p1, p2, k3. The centre of the upper left pixel is
    (0, 0), y down. The polynomial distorts: from the ideal to the measured position.
metashape
    f, cx, cy [pixels] from the centre of the image, b1, b2, k1 to k4, p1, p2. The upper
    left corner of the image is (0, 0), the centre of the first pixel (0.5, 0.5), y
    down. It distorts as well, but p1 and p2 have exchanged their roles.
mm
    c, x0, y0 [mm], y up, as in BINGO and in certificates of calibration; k1 to k3, p1,
    p2 after Brown. The polynomial corrects: from the measured to the ideal position.
micmac
    f, cx, cy, centre_x, centre_y [pixels], y down, k1 to k5 [1/px², 1/px⁴ …], p1, p2
    [1/px], b1, b2. It distorts, about a centre of its own, and the affinity is one of
    the ideal position.

All become the same: an affine map of the measured coordinates to multiples of the
principal distance, and one polynomial, taken in one direction or the other.

Sources: Brown 1971 (Close-Range Camera Calibration, Photogrammetric Engineering 37(8));
the manuals of OpenCV and Agisoft Metashape. See docs/theory/interior_orientation.md.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from einschalt.foundations.arguments import as_numbers, described, finite_number
from einschalt.foundations.errors import SettingsError
from einschalt.foundations.units import MM_PER_UM

# what an inverted polynomial may miss [mm], and the steps that Newton's method may take
CLOSED_MM = 1e-10
MOST_STEPS = 30
LARGEST_CONSTANT = 1e30  # beyond all sense, and far from what overflows
SMALLEST_DISTANCE_MM, LARGEST_DISTANCE_MM = 1.0, 5000.0


@dataclass(frozen=True, eq=False)
class Camera:
    """A calibrated camera, from ``Camera.from_opencv`` or another convention.

    Coordinates that are "scaled" are multiples of the principal distance, from the
    principal point, y up.

    Attributes
    ----------
    principal_distance_mm : float
        [mm]
    radial : tuple of 4 or 5 floats
        k1 to k4, or to k5, of scaled coordinates.
    tangential : tuple of 2 floats
        ``dx = p1 (r² + 2 x²) + 2 p2 x y`` and ``dy = p2 (r² + 2 y²) + 2 p1 x y``.
    is_correcting : bool
        Whether the polynomial leads from the measured to the ideal position.
    matrix : ndarray, shape (2, 2)
        Derivatives of the measured by the scaled coordinates.
    origin : ndarray, shape (2,)
        Measured coordinates of the principal point.
    given : Mapping
        The constants as they were given, with their convention.
    affinity : tuple of 2 floats
        ``dx = a1 x + a2 y`` of the polynomial.
    centre : tuple of 2 floats
        Scaled coordinates about which the polynomial is taken.
    """

    principal_distance_mm: float
    radial: tuple[float, ...]
    tangential: tuple[float, float]
    is_correcting: bool
    matrix: np.ndarray
    origin: np.ndarray
    given: MappingProxyType = field(default_factory=lambda: MappingProxyType({}))
    affinity: tuple[float, float] = (0.0, 0.0)
    centre: tuple[float, float] = (0.0, 0.0)

    def __post_init__(self):
        """Refuse what would make nonsense of every ray."""
        distance = self.principal_distance_mm
        if not SMALLEST_DISTANCE_MM <= distance <= LARGEST_DISTANCE_MM:
            raise SettingsError(
                f"the camera has a principal distance of {distance:.6g} mm",
                expected=f"{SMALLEST_DISTANCE_MM:g} to {LARGEST_DISTANCE_MM:g} mm",
                remedy="Check the unit of the focal length and pixel_size_um",
            )
        numbers = [*self.radial, *self.tangential, *self.matrix.flat, *self.origin]
        numbers += [*self.affinity, *self.centre]
        is_sane = np.abs(numbers).max() <= LARGEST_CONSTANT
        if not is_sane or np.linalg.det(self.matrix) == 0.0:
            raise SettingsError(
                "a constant of the camera is not a finite number, or a scale is zero",
                expected=f"the constants of a calibration, below {LARGEST_CONSTANT:g}",
            )

    def xy_from_measured(self, measured: ArrayLike) -> NDArray[np.float64]:
        """Image coordinates of measured positions.

        Parameters
        ----------
        measured : ndarray, shape (..., 2)
            Pixels (column, row), or millimetres, as the camera was given.

        Returns
        -------
        ndarray, shape (..., 2)
            x, y [mm], origin in the principal point, y up, without distortion; NaN
            where the polynomial has no inverse.

        Examples
        --------
        >>> camera = Camera.from_opencv(8000, 8000, 3999.5, 2999.5, pixel_size_um=5)
        >>> camera.xy_from_measured([3999.5, 2799.5])
        array([0., 1.])
        """
        offset = np.asarray(measured, dtype=float) - self.origin
        scaled = offset @ np.linalg.inv(self.matrix).T
        ideal = self._displaced(scaled) if self.is_correcting else self._undone(scaled)
        # no negative zeros: they are printed
        return self.principal_distance_mm * ideal + 0.0

    def measured_from_xy(self, xy: ArrayLike) -> NDArray[np.float64]:
        """Positions at which image coordinates would be measured.

        Parameters
        ----------
        xy : ndarray, shape (..., 2)
            [mm], origin in the principal point, y up, without distortion.

        Returns
        -------
        ndarray, shape (..., 2)
            In the unit and the system of the measurements; NaN where the polynomial
            has no inverse.
        """
        ideal = np.asarray(xy, dtype=float) / self.principal_distance_mm
        scaled = self._undone(ideal) if self.is_correcting else self._displaced(ideal)
        return self.origin + scaled @ self.matrix.T

    def _displaced(self, scaled):
        """Positions after the polynomial."""
        (x0, y0), (a1, a2) = self.centre, self.affinity
        x, y = scaled[..., 0] - x0, scaled[..., 1] - y0
        (p1, p2), square = self.tangential, x * x + y * y
        growth = 1.0 + square * _polynomial(self.radial, square)
        dx = p1 * (square + 2.0 * x * x) + 2.0 * p2 * x * y + (a1 * x + a2 * y)
        dy = p2 * (square + 2.0 * y * y) + 2.0 * p1 * x * y
        return np.stack([x0 + (growth * x + dx), y0 + (growth * y + dy)], axis=-1)

    def _slopes(self, scaled):
        """Derivatives of the displaced positions, shape (..., 2, 2)."""
        (x0, y0), (a1, a2) = self.centre, self.affinity
        x, y = scaled[..., 0] - x0, scaled[..., 1] - y0
        (p1, p2), square = self.tangential, x * x + y * y
        growth = 1.0 + square * _polynomial(self.radial, square)
        rates = [(n + 1) * k for n, k in enumerate(self.radial)]
        # twice the derivative of the growth by the square of the radius
        rate = 2.0 * _polynomial(rates, square)
        across = rate * x * y + 2.0 * (p1 * y + p2 * x)
        along_x = growth + rate * x * x + 6.0 * p1 * x + 2.0 * p2 * y
        along_y = growth + rate * y * y + 6.0 * p2 * y + 2.0 * p1 * x
        rows = [[along_x + a1, across + a2], [across, along_y]]
        return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)

    def _undone(self, displaced):
        """Positions before the polynomial, by Newton's method from where they are."""
        if not any((*self.radial, *self.tangential, *self.affinity)):
            return displaced
        closed = CLOSED_MM / self.principal_distance_mm
        found = displaced.copy()
        with np.errstate(all="ignore"):
            for _ in range(MOST_STEPS):
                missing = displaced - self._displaced(found)
                step = _solved(self._slopes(found), missing)
                found = found + step
                if not np.nanmax(np.abs(step), initial=0.0) > 1e-3 * closed:
                    break
            missing = np.abs(displaced - self._displaced(found)).max(axis=-1)
            slopes = self._slopes(found)
            # beyond the radius at which the polynomial turns back is no inverse
            is_inverse = (missing <= closed) & _is_upright(slopes)
        return np.where(is_inverse[..., None], found, np.nan)

    @classmethod
    def from_opencv(
        cls,
        fx: float,
        fy: float,
        cx: float,
        cy: float,
        distortion: Sequence[float] = (),
        *,
        pixel_size_um: float,
    ) -> Self:
        """Camera in the convention of OpenCV.

        Parameters
        ----------
        fx, fy : float
            Focal lengths [pixels].
        cx, cy : float
            Principal point [pixels]; the centre of the upper left pixel is (0, 0).
        distortion : sequence of up to 5 floats, optional
            k1, k2, p1, p2, k3, in this order.
        pixel_size_um : float
            Width of a pixel [µm]: it makes millimetres of pixels, and no more.

        Returns
        -------
        Camera
            For positions (column, row) [pixels].

        Raises
        ------
        SettingsError
            More than five coefficients, or values that no camera has.
        """
        constants = _filled("distortion", distortion, ("k1", "k2", "p1", "p2", "k3"))
        k1, k2, p1, p2, k3 = constants.values()
        fx, fy = finite_number("fx", fx), finite_number("fy", fy)
        cx, cy = finite_number("cx", cx), finite_number("cy", cy)
        pixel_size_um = finite_number("pixel_size_um", pixel_size_um)
        return cls(
            principal_distance_mm=fx * pixel_size_um * MM_PER_UM,
            radial=(k1, k2, k3, 0.0),
            # OpenCV's p1 belongs to y; y down turns the sign of what belongs to y
            tangential=(p2, -p1),
            is_correcting=False,
            matrix=np.diag([fx, -fy]),
            origin=np.array([cx, cy]),
            given=_said(
                "opencv",
                {"fx": fx, "fy": fy, "cx": cx, "cy": cy},
                constants,
                pixel_size_um=pixel_size_um,
            ),
        )

    @classmethod
    def from_metashape(
        cls,
        f: float,
        size: Sequence[int],
        centre: Sequence[float] = (0.0, 0.0),
        distortion: Mapping[str, float] | None = None,
        *,
        pixel_size_um: float,
    ) -> Self:
        """Camera in the convention of Agisoft Metashape.

        Parameters
        ----------
        f : float
            Focal length [pixels].
        size : pair of int
            Width and height of the image [pixels].
        centre : pair of floats, optional
            cx, cy: principal point from the centre of the image [pixels], y down.
        distortion : Mapping, optional
            Any of b1, b2 [pixels], k1, k2, k3, k4, p1, p2.
        pixel_size_um : float
            [µm]

        Returns
        -------
        Camera
            For positions (column, row) [pixels], the upper left corner of the image
            being (0, 0).

        Raises
        ------
        SettingsError
            A coefficient is unknown, or values that no camera has.
        """
        names = ("b1", "b2", "k1", "k2", "k3", "k4", "p1", "p2")
        constants = _filled("distortion", distortion, names)
        b1, b2, k1, k2, k3, k4, p1, p2 = constants.values()
        f, (cx, cy) = finite_number("f", f), _pair("centre", centre)
        width, height = _pair("size", size)
        pixel_size_um = finite_number("pixel_size_um", pixel_size_um)
        return cls(
            principal_distance_mm=f * pixel_size_um * MM_PER_UM,
            radial=(k1, k2, k3, k4),
            tangential=(p1, -p2),
            is_correcting=False,
            matrix=np.array([[f + b1, -b2], [0.0, -f]], dtype=float),
            origin=np.array([0.5 * width + cx, 0.5 * height + cy], dtype=float),
            given=_said(
                "metashape",
                {"f": f, "cx": cx, "cy": cy, "width": width, "height": height},
                constants,
                pixel_size_um=pixel_size_um,
            ),
        )

    @classmethod
    def from_mm(
        cls,
        c: float,
        principal_point: Sequence[float] = (0.0, 0.0),
        distortion: Mapping[str, float] | None = None,
        *,
        pixels: Mapping[str, Any] | None = None,
    ) -> Self:
        """Camera in millimetres, as in BINGO and in certificates of calibration.

        Parameters
        ----------
        c : float
            Principal distance [mm].
        principal_point : pair of floats, optional
            x0, y0 [mm], y up, from the origin of the measurements or, with ``pixels``,
            from the centre of the image.
        distortion : Mapping, optional
            Any of k1 [1/mm²], k2 [1/mm⁴], k3 [1/mm⁶], p1, p2 [1/mm], after Brown: what
            is ADDED to the measured coordinates is ``x (k1 r² + k2 r⁴ + k3 r⁶) + p1
            (r² + 2 x²) + 2 p2 x y``, and the same with x and y, p1 and p2 exchanged.
        pixels : Mapping, optional
            pixel_size_um, width and height, where the measurements are pixels, the
            upper left corner of the image being (0, 0); and pixel_height_um, where
            pixels are not square.

        Returns
        -------
        Camera
            For positions in millimetres, y up, or (column, row) [pixels].

        Raises
        ------
        SettingsError
            A coefficient is unknown, or values that no camera has.
        """
        names = ("k1", "k2", "k3", "p1", "p2")
        constants = _filled("distortion", distortion, names)
        k1, k2, k3, p1, p2 = constants.values()
        c, (x0, y0) = finite_number("c", c), _pair("principal_point", principal_point)
        matrix, origin = np.diag([c, c]), np.array([x0, y0])
        grid = {}
        if pixels is not None:
            names = ("pixel_size_um", "width", "height", "pixel_height_um")
            grid = _filled("pixels", pixels, names)
            if not grid["pixel_height_um"]:
                del grid["pixel_height_um"]  # square, as most are
            across = grid["pixel_size_um"] or np.nan
            pitch = MM_PER_UM * np.array([across, grid.get("pixel_height_um", across)])
            matrix = np.diag(c / pitch) @ np.diag([1.0, -1.0])
            middle = np.array([0.5 * grid["width"], 0.5 * grid["height"]])
            with np.errstate(over="ignore"):  # what is infinite then is refused
                origin = middle + np.array([x0, -y0]) / pitch
        return cls(
            principal_distance_mm=c,
            radial=(k1 * c**2, k2 * c**4, k3 * c**6, 0.0),
            tangential=(p1 * c, p2 * c),
            is_correcting=True,
            matrix=matrix,
            origin=origin,
            given=_said("mm", {"c": c, "x0": x0, "y0": y0}, constants, **grid),
        )

    @classmethod
    def from_micmac(
        cls,
        f: float,
        principal_point: Sequence[float],
        distortion: Mapping[str, float] | None = None,
        centre: Sequence[float] | None = None,
        *,
        pixel_size_um: float,
    ) -> Self:
        """Camera in the convention of MicMac (``ModRad``, ``ModPhgrStd``).

        Parameters
        ----------
        f : float
            Focal length ``F`` [pixels].
        principal_point : pair of floats
            ``PP`` [pixels], y down.
        distortion : Mapping, optional
            Any of k1 to k5 (``CoeffDist``) [1/px², 1/px⁴ …], p1, p2 [1/px], b1, b2.
        centre : pair of floats, optional
            ``CDist``, the centre of the distortion [pixels]; that of the principal
            point where it is not given.
        pixel_size_um : float
            [µm]

        Returns
        -------
        Camera
            For positions (column, row) [pixels], as MicMac counts them.

        Raises
        ------
        SettingsError
            A coefficient is unknown, or values that no camera has.
        """
        radial = ("k1", "k2", "k3", "k4", "k5")
        names = (*radial, "p1", "p2", "b1", "b2")
        constants = _filled("distortion", distortion, names)
        p1, p2, b1, b2 = (constants[name] for name in names[len(radial) :])
        f, (cx, cy) = finite_number("f", f), _pair("principal_point", principal_point)
        x, y = (cx, cy) if centre is None else _pair("centre", centre)
        numbers = {"f": f, "cx": cx, "cy": cy, "centre_x": x, "centre_y": y}
        with np.errstate(all="ignore"):
            # of an impossible focal length the principal distance is told
            away = np.array([x - cx, cy - y]) / (f or np.nan)
            scales = np.float64(f) ** np.arange(2, 2 * len(radial) + 1, 2)
            radial = [constants[name] for name in radial] * scales
        pixel_size_um = finite_number("pixel_size_um", pixel_size_um)
        return cls(
            principal_distance_mm=f * pixel_size_um * MM_PER_UM,
            radial=tuple(radial.tolist()),
            # y down turns the sign of what belongs to y
            tangential=(p1 * f, -p2 * f),
            is_correcting=False,
            matrix=np.diag([f, -f]),
            origin=np.array([cx, cy]),
            given=_said("micmac", numbers, constants, pixel_size_um=pixel_size_um),
            affinity=(b1, -b2),
            centre=tuple(away.tolist()),
        )


def _polynomial(coefficients, square):
    """Sum of coefficients times powers of the square, from power 0."""
    total = 0.0
    for coefficient in reversed(coefficients):
        total = total * square + coefficient
    return total


def _solved(matrix, right):
    """Solution of systems of two equations."""
    a, b, c, d = np.moveaxis(matrix.reshape(*matrix.shape[:-2], 4), -1, 0)
    x, y = right[..., 0], right[..., 1]
    determinant = (a * d - b * c)[..., None]
    return np.stack([d * x - b * y, a * y - c * x], axis=-1) / determinant


def _is_upright(matrix):
    """Whether neither axis is mirrored; of a symmetric one, that it is definite."""
    a, b, c, d = np.moveaxis(matrix.reshape(*matrix.shape[:-2], 4), -1, 0)
    return (a > 0.0) & (a * d - b * c > 0.0)


def _filled(what, given, names):
    """Constants by name, those that are not given being zero."""
    if given is None:
        given = {}
    if not isinstance(given, Mapping):
        values = np.ravel(as_numbers(what, given))
        if len(values) > len(names):
            raise SettingsError(
                f"{what} has {len(values)} coefficients", expected=", ".join(names)
            )
        given = dict(zip(names, values.tolist(), strict=False))
    unknown = [name for name in given if name not in names]
    if unknown:
        raise SettingsError(
            f"{what} has the unknown coefficient {described(unknown[0])}",
            expected=", ".join(names),
        )
    return {
        name: finite_number(f"{what} {name}", given.get(name, 0.0)) for name in names
    }


def _pair(name, value):
    values = as_numbers(name, value, expected="a pair of numbers")
    if values.shape == (2,) and np.isfinite(values).all():
        return values.tolist()
    raise SettingsError(f"{name} = {described(value)}", expected="a pair of numbers")


def _said(convention, numbers, constants, **more):
    """Everything that was given, without coefficients that are zero."""
    used = {name: value for name, value in constants.items() if value != 0.0}
    return MappingProxyType({"convention": convention, **numbers, **used, **more})
