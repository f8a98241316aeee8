"""A planned block in its planner's words, as geometry and noise of a simulation."""

from dataclasses import dataclass, replace
from functools import cached_property
from numbers import Real

from einschalt.foundations.arguments import described
from einschalt.foundations.errors import SettingsError
from einschalt.foundations.known_fields import with_known_fields
from einschalt.foundations.units import METRES_PER_UM
from einschalt.pipeline.planning.flights.arguments import RANGES as ASKED
from einschalt.pipeline.planning.flights.arguments import (
    checked_axis,
    checked_number,
    flown_model,
    shown,
)
from einschalt.pipeline.planning.flights.points_in_models import require_points
from einschalt.pipeline.simulation.geometry import RANGES as BLOCK_RANGES
from einschalt.pipeline.simulation.geometry import BlockGeometry, least_overlaps
from einschalt.pipeline.simulation.noise import BlockNoise
from einschalt.theory.planning.expected_precision import models_per_point
from einschalt.theory.planning.kovarik_precision import (
    PlannedModel,
    PlannedPrecision,
    planned_precision,
)
from einschalt.theory.planning.leverage import LEAST_POINTS

HIGH_OVER_LOW_SCALE = 15_000 / 8_000  # as at Neukirchen: 1:15000 above 1:8000
RIM_OVER_SIDE = 1 / 46  # 5 mm of 23 cm
HIGH_FOOTPRINTS = 3.0
LEAST_ROWS, MOST_ROWS = 16, 70
SHORTEST_SIDE = BLOCK_RANGES["width"].low  # metres, of an extent that is left out
LEAST_POINTS_PER_MODEL = max(LEAST_POINTS.values()) + 1
"""That a layout has in a model: more than any transformation needs, for residuals."""
NODES_IN_A_MODEL = {5: 6.25, 9: 9.0}
"""By control per model: nodes of a lattice of control so dense that a model of the high
flight, its whole overlap, holds enough of it wherever it lies."""
MOST_WORK = 1e7
"""Values times pairs of models at a point: a second of propagation at most."""


@with_known_fields
@dataclass(frozen=True, kw_only=True)
class FlightDesign:
    """Two planned flights: the choices of the planner and the given conditions.

    Attributes
    ----------
    scale_number : float
        Denominator of the image scale of the low flight.
    spacing : float
        Mean distance of points [m].
    m_g_um : float
        TOTAL error of a point measured in the low flight, in the image plane [µm]; of
        the mean, where it is set several times.
    kind : {"affine", "helmert", "rigid"}
        How the models of both flights are fitted.
    image_format : float or tuple of float
        Side of the image, or its sides along and across the strip [m].
    principal_distance : float
        [m]
    forward_overlap, side_overlap : float
        Of consecutive images, and of neighbouring strips; parts of the image, 0 to 1.
    n_coverages : int
        Coverages of both flights, 1 to 4.
    coverage_shift : float, optional
        Shift of a coverage against the one before, in bases; 1/n_coverages where left
        out.
    high_scale_number : float, optional
        Denominator of the high flight; 1.875 times that of the low flight where left
        out, as in 1971.
    high_m_g_um : float, optional
        As ``m_g_um``, of the high flight [µm]; that of the low flight where left out.
    control_standard_error : float
        TOTAL error of terrestrial control in plan [m].
    control_per_model : {5, 9}
        Control points in each model of the high flight.
    width, height : float, optional
        Extent of the area from west to east and from south to north [m]; enough for
        three high-flight images where left out.
    most_work : float
        Size of the layout (values times pairs of models at a point) beyond which its
        points are thinned.
    """

    scale_number: float
    spacing: float
    m_g_um: float
    kind: str = "affine"
    image_format: float | tuple[float, float] = 0.23
    principal_distance: float = 0.152
    forward_overlap: float = 0.60
    side_overlap: float = 0.30
    n_coverages: int = 2
    coverage_shift: float | None = None
    high_scale_number: float | None = None
    high_m_g_um: float | None = None
    control_standard_error: float = 0.03
    control_per_model: int = 5
    width: float | None = None
    height: float | None = None
    most_work: float = MOST_WORK

    def __post_init__(self):
        """Check the values that the simulation does not know by these names."""
        for name in ("scale_number", "spacing", "m_g_um", "principal_distance"):
            checked_number(name, getattr(self, name))
        for name in ("scale_number", "m_g_um"):
            if (value := getattr(self, f"high_{name}")) is not None:
                _checked_of_high_flight(name, value)
        if self.scale_of_high_flight <= self.scale_number:
            raise SettingsError(
                f"high_scale_number = {self.scale_of_high_flight:g}, with a low flight "
                f"of {self.scale_number:g}",
                expected="a high flight of a smaller image scale",
                remedy="Give the larger denominator to the high flight",
            )
        _check_work(self.most_work)
        require_overlaps(self.image_format, self.forward_overlap, self.side_overlap)
        require_points(self.model, self.scale_number, self.spacing)
        self._require_close_points()
        self.geometry()
        self.noise()

    @cached_property
    def model(self) -> PlannedModel:
        """The planned model of the low flight, its edge by the rule of 1971."""
        return flown_model(self)

    @property
    def scale_of_high_flight(self) -> float:
        """Scale number of the high flight, where None has been replaced."""
        if self.high_scale_number is not None:
            return float(self.high_scale_number)
        return HIGH_OVER_LOW_SCALE * self.scale_number

    @property
    def extent(self) -> tuple[float, float]:
        """Width and height of the area, where None has been replaced [m]."""
        footprint = self.scale_of_high_flight * max(self.model.image_format)
        least, most = LEAST_ROWS * self.spacing, MOST_ROWS * self.spacing
        usual = min(max(HIGH_FOOTPRINTS * footprint, least), most)
        usual = max(usual, SHORTEST_SIDE)
        given = (self.width, self.height)
        width, height = (usual if side is None else float(side) for side in given)
        return width, height

    @property
    def work_of_a_point(self) -> float:
        """Values times pairs of models at a point, of all coverages."""
        return (self.n_coverages * models_per_point(self.model)) ** 3

    @property
    def layout_spacing(self) -> float:
        """Distance of the points of the layout [m].

        Where dozens of models hold a point it is larger than planned: fewer points,
        with the same control, make the same errors, to some 2 %, if models are fitted
        on each as on the mean of all for which it stands.
        """
        width, height = self.extent
        work = width * height / self.spacing**2 * self.work_of_a_point
        return float(self.spacing) * max(1.0, work / self.most_work) ** 0.5

    def _require_close_points(self):
        """Refuse an area so large that its layout has no points close enough."""
        apart, most = self.layout_spacing, BLOCK_RANGES["point_spacing"].high
        if apart <= most:
            return
        width, height = self.extent
        remedy = "Give a smaller --spacing, less overlap, or fewer coverages"
        if self.width is not None or self.height is not None:
            remedy = (
                "Give a smaller --width and --height, less overlap, or fewer coverages"
            )
        raise SettingsError(
            f"the layout of an area of {width:.0f} x {height:.0f} m would have points "
            f"{apart:.0f} m apart, to be computed in time",
            expected=f"at most {most:g} m",
            remedy=remedy,
        )

    def geometry(self) -> BlockGeometry:
        """Return the layout of both flights over the area."""
        return self._geometry

    @cached_property
    def _geometry(self):
        along, across = self.model.image_format
        width, height = self.extent
        return BlockGeometry(
            width=width,
            height=height,
            point_spacing=self.layout_spacing,
            high_scale_number=self.scale_of_high_flight,
            low_scale_number=float(self.scale_number),
            image_format=along,
            image_format_across=across,
            principal_distance=float(self.principal_distance),
            forward_overlap=float(self.forward_overlap),
            side_overlap=float(self.side_overlap),
            unusable_rim=_rim(self.model),
            n_coverages=self.n_coverages,
            coverage_shift=self.coverage_shift,
            control_per_model=self.control_per_model,
            # as few points as possible, each measured wherever it shows
            control_reach=1.0,
            shares_control=True,
            least_points_per_model=LEAST_POINTS_PER_MODEL,
            transformation=self.kind,
        )

    def noise(self) -> BlockNoise:
        """Return the errors of control and measurements."""
        given = self.high_m_g_um
        return BlockNoise(
            control_standard_error=float(self.control_standard_error),
            high_m_g_um=self.m_g_um if given is None else given,
            low_m_g_um=float(self.m_g_um),
        )

    def after_kovarik(self, m_0: float) -> PlannedPrecision:
        """Precision after Kovarik's formula and edge.

        ``m_0`` is the TOTAL error of the approximate coordinates [m].
        """
        m_g = self.m_g_um * METRES_PER_UM
        return planned_precision(self.scale_number, self.spacing, m_0, m_g, self.model)


def usable_model(model) -> tuple[float, float]:
    """Measurable extent of a model along and across its strip [m in the image]."""
    along, across = model.image_format
    rims = 2.0 * _rim(model)
    return model.forward_overlap * along - rims, across - rims


def _rim(model):
    return _rim_of(*model.image_format)


def _rim_of(along, across):
    return min(along, across) * RIM_OVER_SIDE


def require_overlaps(image_format, forward_overlap, side_overlap):
    """Refuse overlaps with which no layout is made.

    ``image_format``: one side or both, along and across [m]; overlaps are parts of the
    image. SettingsError where models would leave gaps, or photographs lie too close.
    """
    sides = checked_axis("image_format", image_format)
    along, across = float(sides[0]), float(sides[-1])
    least = least_overlaps(along, across, _rim_of(along, across))
    given = {"forward_overlap": forward_overlap, "side_overlap": side_overlap}
    for name, value in given.items():
        without_gaps, of_blocks = least[name], BLOCK_RANGES[name]
        low = max(of_blocks.low, without_gaps)
        allowed = replace(ASKED[name], low=low, high=of_blocks.high, unit="")
        if value not in allowed:
            leaves_gaps = isinstance(value, Real) and value < low
            raise SettingsError(
                f"{name} = {shown(value)}",
                expected=f"{allowed} of the image, so that models leave no gaps"
                if leaves_gaps
                else f"{allowed} of the image",
                remedy=allowed.remedy_for(value),
            )


def _check_work(most_work):
    """See that a limit is one; infinite is none, which is allowed."""
    is_number = isinstance(most_work, Real) and not isinstance(most_work, bool)
    if not is_number or not most_work > 0.0:
        raise SettingsError(
            f"most_work = {described(most_work)}", expected="a number above 0"
        )


def _checked_of_high_flight(name, value):
    try:
        checked_number(name, value)
    except SettingsError as error:
        raise error.with_facts(found=f"high_{error.found}") from None
