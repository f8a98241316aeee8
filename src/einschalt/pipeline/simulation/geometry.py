"""What a simulated block looks like: area, points, flights, and what is measured.

Everything here is free of error; what disturbs it stands in
:mod:`einschalt.pipeline.simulation.noise`. The defaults are the block behind the
figures of the documentation, after the test block Neukirchen of Kovarik 1971.
"""

import math
from dataclasses import dataclass

from einschalt.foundations.arguments import described, is_choice
from einschalt.foundations.errors import ProjectionError, SettingsError, raise_problems
from einschalt.foundations.kept_texts import kept
from einschalt.foundations.known_fields import with_known_fields
from einschalt.foundations.language import mark, mark_each
from einschalt.foundations.projections import read_crs
from einschalt.foundations.value_ranges import Range, problems_in
from einschalt.pipeline.block.facts import TRANSFORMATIONS

MEASUREMENTS = ("machine", "parallaxes", "images")
CONTROL_PATTERNS = (5, 9)
MOST_POINTS = 5_000_000
HIGHEST_RELIEF = 4.0  # standard deviations: eight waves of the terrain at their crests
IN_MM = {"likely_slip": "Did you give millimetres?", "slips": (0.1, 1000)}
TOLERANCE = 1e-9  # of image lengths [m]: they are sums of decimals

RANGES = {
    "width": Range(100, 1_000_000, "metres"),
    "height": Range(100, 1_000_000, "metres"),
    "point_spacing": Range(0.5, 50_000, "metres"),
    "jitter": Range(0, 0.49, "of the point spacing"),
    "high_scale_number": Range(100, 200_000),
    "low_scale_number": Range(100, 200_000),
    "image_format": Range(0.002, 1, "metres", **IN_MM),
    "image_format_across": Range(0.002, 1, "metres", **IN_MM),
    "principal_distance": Range(0.002, 1, "metres", **IN_MM),
    "forward_overlap": Range(0.5, 0.95, "of the image format"),
    "side_overlap": Range(0, 0.9, "of the image format"),
    "unusable_rim": Range(0, 0.1, "metres", **IN_MM),
    "n_coverages": Range(1, 4, is_whole=True),
    "coverage_shift": Range(0, 1, "of a base"),
    "control_reach": Range(0.5, 1.3, "of the half neat model"),
    "n_check": Range(0, MOST_POINTS, is_whole=True),
    "least_points_per_model": Range(3, 1000, is_whole=True),
    "centre_easting": Range(-1e9, 1e9, "metres"),
    "centre_northing": Range(-1e9, 1e9, "metres"),
    "mean_height": Range(-500, 9000, "metres"),
    "relief": Range(0, 200, "metres"),
    "camera_tilt": Range(0, 0.05, "radians"),
}
OPTIONAL = ("image_format_across", "coverage_shift")
ALONG = mark(
    "the models, {size} mm along the strip, leave gaps between models {step} mm apart"
)
ACROSS = mark(
    "the models, {size} mm across the strip, leave gaps between strips {step} mm apart"
)
APART = mark_each(
    {
        "models": "models at most as far apart as the models are wide",
        "strips": "strips at most as far apart as the models are wide",
    }
)


@with_known_fields
@dataclass(frozen=True, kw_only=True)
class BlockGeometry:
    """Area, points and flights of a simulated block, all free of error.

    Attributes
    ----------
    width, height : float
        Extent of the area in easting and northing [m].
    point_spacing : float
        Spacing of the lattice on which the points lie [m].
    jitter : float
        Largest displacement of a point from its lattice place, in each axis, as a
        fraction of the spacing. The outermost points are moved inward only.
    high_scale_number, low_scale_number : float
        Denominators of the image scales.
    image_format, principal_distance : float
        Side of the image along the strip, and the camera's principal distance [m].
    image_format_across : float, optional
        Side of the image across the strip; None is a square image [m].
    forward_overlap, side_overlap : float
        Of consecutive images, and of neighbouring strips; a little more where equal
        bases keep the centre of every model on the block.
    unusable_rim : float
        Rim of the image in which nothing is measured [m].
    n_coverages : int
        How often each flight covers the block; coverage k is shifted by k/n of a base
        and of a strip distance against the first.
    coverage_shift : float, optional
        In place of 1/n: how far each coverage is shifted against the one before. 0
        flies the same models again.
    high_cross_flight, low_cross_flight : bool
        Whether every second coverage is flown across the others, northward.
    control_per_model : {5, 9}
        High-flight control: the points nearest to the corners and the centre of each
        neat model (or to its border inside the block), or to 3 x 3 places in it.
    shares_control : bool
        Whether the control of its neighbours is measured in a model too, where it
        shows; in photographs it always is.
    control_reach : float
        How far from the centre of a neat model its control is wanted, 1 at its corners.
        A little beyond them, not all models that meet there take the same point.
    n_check : int
        How many new points have given coordinates too, in the role ``check``.
    least_points_per_model : int
        A model with fewer points is not measured.
    centre_easting, centre_northing : float
        Centre of the area [m]; by default Neukirchen an der Vöckla.
    crs : str, optional
        System of the ground coordinates; None is a plane of its own, on a flat Earth.
    mean_height, relief : float
        Mean height of the terrain, and the standard deviation of its smooth waves [m].
        Machine coordinates come from an orthogonal model, which relief does not bend;
        it matters where heights, parallaxes or images are measured.
    measurement : {"machine", "parallaxes", "images"}
        What the tables hold: machine coordinates of oriented models; machine
        coordinates of models that still have errors of relative orientation, with the
        y-parallaxes at the six standard points; or image coordinates.
    transformation : {None, "affine", "helmert", "rigid", "helmert_3d"}
        How the models are fitted. None takes affine, and helmert_3d for images, whose
        models are not levelled. With helmert_3d all tables have heights.
    camera_tilt : float
        Standard deviation of each rotation of an image [rad].

    Raises
    ------
    SettingsError, ProjectionError, BlockError
        A value lies outside its range, the system is no plane one, or the models would
        leave gaps.

    Examples
    --------
    >>> BlockGeometry().image_base
    0.092
    >>> BlockGeometry(side_overlap=0.0)
    Traceback (most recent call last):
    einschalt.foundations.errors.SettingsError: the models, 220 mm \
across the strip, leave gaps between strips 230 mm apart; expected strips at most as \
far apart as the models are wide. Raise side_overlap to 0.0435 or more.
    """

    width: float = 10_400.0
    height: float = 10_200.0
    point_spacing: float = 300.0
    jitter: float = 0.3
    high_scale_number: float = 15_000.0
    low_scale_number: float = 8_000.0
    image_format: float = 0.23
    principal_distance: float = 0.153
    forward_overlap: float = 0.60
    side_overlap: float = 0.30
    unusable_rim: float = 0.005
    n_coverages: int = 2
    high_cross_flight: bool = False
    low_cross_flight: bool = False
    control_per_model: int = 5
    shares_control: bool = False
    control_reach: float = 1.02
    n_check: int = 0
    least_points_per_model: int = 6
    centre_easting: float = 15_100.0
    centre_northing: float = 321_900.0
    crs: str | None = "EPSG:31255"
    mean_height: float = 520.0
    relief: float = 30.0
    measurement: str = "machine"
    transformation: str | None = None
    camera_tilt: float = 0.01
    image_format_across: float | None = None
    coverage_shift: float | None = None

    def __post_init__(self):
        """Check every value, then what they give together."""
        left_out = {name for name in OPTIONAL if getattr(self, name) is None}
        given = {name: RANGES[name] for name in RANGES if name not in left_out}
        raise_problems([*problems_in(self, given), *self._problems_of_choice()])
        raise_problems([*self._problems_of_size(), *self._problems_of_gaps()])

    @property
    def image_base(self) -> float:
        """Distance of consecutive images, in the image plane [m]."""
        return round((1.0 - self.forward_overlap) * self.image_format, 12)

    @property
    def image_strip_distance(self) -> float:
        """Distance of neighbouring strips, in the image plane [m]."""
        return round((1.0 - self.side_overlap) * self.across, 12)

    @property
    def across(self) -> float:
        """Side of the image across the strip [m]."""
        given = self.image_format_across
        return self.image_format if given is None else given

    @property
    def shift(self) -> float:
        """Shift of each coverage against the one before, in bases."""
        given = self.coverage_shift
        return 1.0 / self.n_coverages if given is None else given

    @property
    def usable_model(self) -> tuple[float, float]:
        """Measurable extent of a model along and across its strip, image plane [m]."""
        along = self.forward_overlap * self.image_format - 2.0 * self.unusable_rim
        across = self.across - 2.0 * self.unusable_rim
        return along, across

    @property
    def neat_model(self) -> tuple[float, float]:
        """Extent of the part of a model that is in no neighbour, image plane [m]."""
        return self.image_base, self.image_strip_distance

    @property
    def n_columns(self) -> int:
        """Number of lattice columns, from west to east."""
        return round(self.width / self.point_spacing)

    @property
    def n_rows(self) -> int:
        """Number of lattice rows, from north to south."""
        return round(self.height / self.point_spacing)

    @property
    def half_extent(self) -> tuple[float, float]:
        """Farthest easting and northing of a point from the centre of the area [m]."""
        columns, rows = self.n_columns - 1, self.n_rows - 1
        return columns * self.point_spacing / 2.0, rows * self.point_spacing / 2.0

    @property
    def transformation_kind(self) -> str:
        """The transformation of both flights, where None has been replaced."""
        default = "helmert_3d" if self.measurement == "images" else "affine"
        return default if self.transformation is None else self.transformation

    @property
    def has_heights(self) -> bool:
        """Whether control, truth and results have heights."""
        return self.transformation_kind == "helmert_3d"

    def flying_height(self, scale_number: float) -> float:
        """Height of the projection centres above the height system's zero [m]."""
        return self.mean_height + self.principal_distance * scale_number

    def _problems_of_choice(self):
        for name in ("high_cross_flight", "low_cross_flight", "shares_control"):
            value = getattr(self, name)
            if not isinstance(value, bool):
                found = f"{name} = {described(value)}"
                yield SettingsError(found, expected="True or False")
        choices = {
            "control_per_model": CONTROL_PATTERNS,
            "measurement": MEASUREMENTS,
            "transformation": (None, *TRANSFORMATIONS),
        }
        for name, allowed in choices.items():
            value = getattr(self, name)
            is_number = value in Range(*CONTROL_PATTERNS) and value in allowed
            if not (is_choice(value, allowed) or is_number):
                yield SettingsError(
                    f"{name} = {described(value)}",
                    expected=" or ".join(str(choice) for choice in allowed),
                )
        try:
            if self.crs is not None:
                read_crs(self.crs)
        except ProjectionError as error:
            yield error

    def _problems_of_size(self):
        n_points = self.n_columns * self.n_rows
        if min(self.n_columns, self.n_rows) < 3:
            yield SettingsError(
                f"{self.n_columns} x {self.n_rows} points lie on "
                f"{self.width:g} x {self.height:g} m",
                expected="at least 3 x 3",
                remedy="Lower point_spacing, or enlarge the area",
            )
        lowest = min(self.high_scale_number, self.low_scale_number)
        flown = self.principal_distance * lowest
        if self.measurement != "machine" and HIGHEST_RELIEF * self.relief > flown / 2:
            yield SettingsError(
                f"relief = {self.relief!r}, with hills up to "
                f"{HIGHEST_RELIEF * self.relief:g} m, {flown:g} m below the camera",
                expected="hills of at most half the flying height",
                remedy="Lower relief, or raise the scale numbers",
            )
        if n_points > MOST_POINTS:
            yield SettingsError(
                f"{n_points} points lie on the area",
                expected=f"at most {MOST_POINTS}",
                remedy="Raise point_spacing, or make several blocks",
            )

    def _problems_of_gaps(self):
        least = least_overlaps(self.image_format, self.across, self.unusable_rim)
        words = (
            ("forward_overlap", ALONG, "models"),
            ("side_overlap", ACROSS, "strips"),
        )
        for (name, message, between), size, step in zip(
            words, self.usable_model, self.neat_model, strict=True
        ):
            if size < step - TOLERANCE:
                in_mm = {"size": f"{1e3 * size:.4g}", "step": f"{1e3 * step:.4g}"}
                yield SettingsError(
                    kept(message, **in_mm),
                    expected=APART[between],
                    remedy=f"Raise {name} to {least[name]:g} or more",
                )


def least_overlaps(along, across, rim) -> dict[str, float]:
    """Overlaps from which on models leave no gaps, by name, rounded up.

    Of images ``along`` by ``across`` with an unusable ``rim`` [m].

    >>> least_overlaps(0.23, 0.23, 0.005)
    {'forward_overlap': 0.522, 'side_overlap': 0.0435}
    """
    forward, side = (1.0 + 2.0 * rim / along) / 2.0, 2.0 * rim / across
    exact = {"forward_overlap": forward, "side_overlap": side}
    return {name: _three_digits_up(least) for name, least in exact.items()}


def _three_digits_up(least):
    """Round up to three digits; what is as round, but for its last bits, stays."""
    if least <= 0.0:
        return least
    n_decimals = 2 - math.floor(math.log10(least))
    return round(math.ceil(round(least * 10.0**n_decimals, 6)) / 10.0**n_decimals, 12)
