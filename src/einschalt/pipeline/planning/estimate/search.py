"""From the wanted precision to the cheapest flight."""

from dataclasses import dataclass, field, fields, replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from einschalt.foundations.arguments import require_choice, require_kind
from einschalt.foundations.errors import SettingsError, raise_problems
from einschalt.foundations.known_fields import with_known_fields
from einschalt.foundations.language import in_english
from einschalt.foundations.units import METRES_PER_UM
from einschalt.foundations.value_ranges import Range, problems_in
from einschalt.pipeline.planning.estimate.further_effort import (
    MOST_PLANS,
    FurtherEfforts,
    further_efforts,
)
from einschalt.pipeline.planning.estimate.possible_layouts import (
    are_possible,
    fits_in,
    of_possible_scales,
    require_possible,
)
from einschalt.pipeline.planning.estimate.text import (
    FORMULAS,
    LIMITS,
    PLACES,
    describe_search,
    describe_verdict,
)
from einschalt.pipeline.planning.estimate.work import (
    ON_LAYOUTS,
    are_densified,
    is_efficient,
    without_control_alone,
    work_for_each_km2,
)
from einschalt.pipeline.planning.flights.arguments import (
    MAX_HEIGHT,
    RANGES,
    checked_axis,
    checked_number,
    flown_model,
    require_extent,
    require_reasonable_size,
    take_single_numbers,
)
from einschalt.pipeline.planning.flights.cameras import (
    CameraPreset,
    camera_preset,
    flown_columns,
)
from einschalt.pipeline.planning.flights.costs import PlanCosts, require_costs
from einschalt.pipeline.planning.flights.points_in_models import (
    model_fill,
    too_few_points,
)
from einschalt.pipeline.planning.tables.precision_table import frame_of
from einschalt.stages.results import Result
from einschalt.theory.measuring_error import m_g_of_mean
from einschalt.theory.planning.expected_precision import (
    ExpectedParts,
    FlightsToExpect,
    expected_parts,
)
from einschalt.theory.planning.kovarik_precision import (
    PlannedModel,
    mean_of_coverages,
    planned_precision,
)

if TYPE_CHECKING:
    import pandas as pd

# fields that a preset of a camera has
OF_CAMERA = (
    *("image_format", "principal_distance", "forward_overlap", "side_overlap"),
    *("max_height", "sampled_um"),
)
EXPECTED = ("centre", "edge", "corner", "mean")  # of ExpectedParts
OF_MEASURING = ("m_g_um", "n_settings")  # in a row, beside what makes its layout


@with_known_fields
@dataclass(frozen=True, kw_only=True)
class PlanChoices:
    """Choices of the planner; every value is combined with every other.

    Attributes
    ----------
    scale_number : tuple of float
        Denominators of the image scale of the low flight.
    spacing : tuple of float
        Mean distances of points [m].
    m_g_um : tuple of float
        TOTAL errors of ONE pointing in the low flight, in the image plane [µm].
    high_over_low : tuple of float
        Scale number of the high flight over that of the low flight.
    n_settings : tuple of int
        Pointings at each point, in both flights.
    n_coverages : tuple of int
        Coverages of both flights, 1 to 4; one shows no gross error.
    control_per_model : tuple of {5, 9}
        Control points in each model of the high flight.
    """

    scale_number: tuple[float, ...]
    spacing: tuple[float, ...]
    m_g_um: tuple[float, ...]
    high_over_low: tuple[float, ...] = (1.25, 1.5, 1.875, 2.5, 3.0)
    n_settings: tuple[int, ...] = (1, 2, 4)
    n_coverages: tuple[int, ...] = (2, 3)
    control_per_model: tuple[int, ...] = (5, 9)

    def __post_init__(self):
        """Take one number as a choice of one."""
        take_single_numbers(self)


@dataclass(frozen=True, eq=False, repr=False)
class PlanSearch(Result):
    """All plans, the cheapest that reach the target first.

    Attributes
    ----------
    target : float
        TOTAL error that the delivered coordinates may have [m].
    where : {"everywhere", "edge", "centre"}
        Place in the models at which it holds.
    by : {"expected", "paper"}
        Estimate that is held against it.
    model : PlannedModel
        A model of the low flight, as far as it is known before the flight.
    plans : DataFrame
        One row for each plan: scale_number, spacing [m], m_g_um [µm],
        high_scale_number, n_settings, n_coverages, control_per_model; flying_height and
        high_flying_height above ground [m], gsd and high_gsd [m] (NaN where no size of
        a pixel is known); n_points, of a model; TOTAL errors [m]: m_0, M_centre,
        M_edge, M_mean (after Kovarik), expected_centre, expected_edge, expected_corner,
        expected_mean (with what points share), reached_expected, reached_paper (at the
        place of the target), reached (the one that is asked for); images, models,
        settings, control_points and cost for each km²; is_feasible, is_efficient (no
        other plan is cheaper and better), limited_by.
    beyond : FurtherEfforts, optional
        What helps that was not among the choices, where no plan reaches the target.
    """

    target: float
    where: str
    by: str
    model: PlannedModel
    plans: "pd.DataFrame"
    beyond: FurtherEfforts | None = None

    @property
    def feasible(self) -> "pd.DataFrame":
        """The plans that reach the target, the cheapest first."""
        return self.plans[self.plans["is_feasible"]]

    @property
    def nearest(self) -> "pd.Series[Any]":
        """The cheapest plan that reaches the target, or the one that comes nearest."""
        if len(self.feasible):
            return self.feasible.iloc[0]
        return self.plans.loc[self.plans["reached"].idxmin()]

    @property
    def verdict(self) -> str:
        """How many plans reach the target, and the best of them, in a sentence."""
        return describe_verdict(self)

    def summary(self) -> str:
        """Return the verdict, the cheapest plans, and what limits the others."""
        return describe_search(self)


ALLOWED_IN_FRAME = {
    "control_standard_error": Range(0, 10, "metres"),
    "high_over_low_m_g": Range(0.01, 100),
}
ALLOWED_WHERE_GIVEN = {
    "max_height": MAX_HEIGHT,
    "sampled_um": Range(0.3, 100, "micrometres in the image"),
}


@with_known_fields
@dataclass(frozen=True, kw_only=True)
class PlanFrame:
    """Given conditions of a plan: camera, transformation, control and costs.

    Attributes
    ----------
    kind : {"affine", "helmert", "rigid"}
        How the models of both flights are fitted.
    image_format : float or tuple of float
        Side of the image, or its sides along and across the strip [m].
    principal_distance : float
        [m]
    forward_overlap, side_overlap : float
        Of consecutive images, and of neighbouring strips; parts of the image, 0 to 1.
    control_standard_error : float
        TOTAL error of terrestrial control in plan [m].
    high_over_low_m_g : float
        Measuring error of the high flight over that of the low flight, in the image.
    costs : PlanCosts
        Prices by which plans are ranked.
    max_height : float, optional
        Height above ground that both flights keep below [m]; None: no limit.
    sampled_um : float, optional
        Size of a pixel in the image [µm], of which gsd is the size on the ground; None:
        film.
    shares_control : bool
        Whether control lies where it serves most models, as a plan over an area sets
        it, and not at the corners of every neat model; it matters where images overlap
        much.
    extent : tuple of float, optional
        Length [m], width [m] and size [m²] of the ground, whose border takes models and
        control as well; None: endless.
    """

    kind: str = "affine"
    image_format: float | tuple[float, float] = 0.23
    principal_distance: float = 0.152
    forward_overlap: float = 0.60
    side_overlap: float = 0.30
    control_standard_error: float = 0.03
    high_over_low_m_g: float = 1.0
    costs: PlanCosts = field(default_factory=PlanCosts)
    max_height: float | None = None
    sampled_um: float | None = None
    shares_control: bool = False
    extent: tuple[float, float, float] | None = None

    def __post_init__(self):
        """Check what no planned model knows."""
        require_costs(self.costs)
        if self.extent is not None:
            require_extent(self.extent)
        given = {
            name: allowed
            for name, allowed in ALLOWED_WHERE_GIVEN.items()
            if getattr(self, name) is not None
        }
        raise_problems(problems_in(self, ALLOWED_IN_FRAME | given))

    @classmethod
    def of_camera(cls, camera: str | CameraPreset, **given: Any) -> "PlanFrame":
        """Take a camera and how it is usually flown, as the command does.

        Parameters
        ----------
        camera : str or CameraPreset
            Its name, as :func:`einschalt.camera_preset` has it, or the preset.
        **given
            Further fields, and those that go before the preset's: image_format,
            principal_distance, forward_overlap, side_overlap, max_height, sampled_um.

        Raises
        ------
        EinschaltError
            There is no such camera, or a value is not sensible.

        Examples
        --------
        >>> PlanFrame.of_camera("uav_one_inch", kind="rigid").max_height
        120.0
        """
        if not isinstance(camera, CameraPreset):
            camera = camera_preset(camera)
        return cls(**{name: getattr(camera, name) for name in OF_CAMERA} | given)


@in_english
def find_plans(target, choices, frame=None, *, where="everywhere", by="expected"):
    """Find the plans that reach a precision, the cheapest first.

    As :func:`einschalt.find_plans`: all figures are closed estimates, not yet checked
    on a layout. The place ``where`` the target holds matters with one coverage only:
    the mean of several is alike everywhere.
    """
    target = checked_number("target", target)
    require_choice("where", where, PLACES)
    require_choice("by", by, FORMULAS)
    require_kind("choices", choices, PlanChoices, expected="a PlanChoices")
    frame = PlanFrame() if frame is None else frame
    require_kind("frame", frame, PlanFrame, expected="a PlanFrame")
    # edges are looked at as the geometry has them; the paper's M takes its own rule
    model = flown_model(frame)
    does = partial(_is_planned, choices, frame, model)
    given = require_possible(_combine(choices), frame)
    columns = _estimated(given, frame, model, where, does)
    columns["reached"] = columns[f"reached_{by}"]
    columns["is_feasible"] = columns["reached"] <= target
    columns["is_efficient"] = is_efficient(columns["cost"], columns["reached"])
    beyond = None
    if not columns["is_feasible"].any():

        def estimate(plans, control_error):
            changed = replace(frame, control_standard_error=control_error)
            columns = _estimated(plans, changed, model, where)
            scales = columns["scale_number"], columns["high_scale_number"]
            is_fit = fits_in(columns, frame.extent, model) & are_possible(*scales)
            return np.where(is_fit, columns[f"reached_{by}"], np.inf)

        given = (choices, frame.control_standard_error, target, estimate)
        beyond = further_efforts(_most_precise(columns), *given)
    table = frame_of(columns)
    order = np.lexsort((table["reached"], table["cost"], ~table["is_feasible"]))
    plans = table.iloc[order].reset_index(drop=True)
    return PlanSearch(target, where, by, model, plans, beyond)


def _estimated(given, frame, model, where, does=lambda **_changes: False):
    """Columns of the combinations that are possible, with what they reach.

    ``does`` tells a refusal what can be advised.
    """
    columns = _precisions(given, frame, model, does)
    columns = columns | work_for_each_km2(columns, frame, model)
    columns = without_control_alone(columns, frame, model, does)
    for formula in FORMULAS:
        columns[f"reached_{formula}"] = _reached(columns, where, formula)
    return columns


def _most_precise(columns):
    """Give the combinations that come nearest to a target, as choices name them."""
    first = np.argsort(columns["reached"], kind="stable")[:MOST_PLANS]
    names = (field.name for field in fields(PlanChoices))
    given = {name: columns[name][first] for name in names if name in columns}
    high, low = (columns[f"{flight}scale_number"][first] for flight in ("high_", ""))
    return given | {"high_over_low": high / low}


ALLOWED_CHOICES = {
    "high_over_low": Range(1.01, 20, "times the low flight's scale number"),
    "n_settings": Range(1, 100, is_whole=True),
    "n_coverages": Range(1, 4, is_whole=True),
    "control_per_model": (5, 9),
}


def _combine(choices):
    axes = {
        name: checked_axis(name, getattr(choices, name))
        for name in ("scale_number", "spacing", "m_g_um")
    }
    for name, allowed in ALLOWED_CHOICES.items():
        values = list(getattr(choices, name))
        wrong = [value for value in values if value not in allowed]
        if wrong or not values:
            raise SettingsError(
                f"{name} = {wrong[0]!r}" if wrong else f"{name} is empty",
                expected="5 or 9" if name == "control_per_model" else str(allowed),
            )
        axes[name] = np.array(values, dtype=float)
    # given twice it would be its own next best
    axes = {name: np.array([*dict.fromkeys(axes[name].tolist())]) for name in axes}
    require_reasonable_size(*axes.values())
    grid = np.meshgrid(*axes.values(), indexing="ij")
    return {name: part.ravel() for name, part in zip(axes, grid, strict=True)}


def _is_planned(choices, frame, model, **changes):
    """Tell whether there is a plan with one value instead of those of a choice."""
    ranges = RANGES | ALLOWED_WHERE_GIVEN
    if any(value not in ranges[name] for name, value in changes.items()):
        return False
    max_height = changes.pop("max_height", frame.max_height)
    others = {name: (value,) for name, value in changes.items()}
    # how well points are measured decides of no combination whether it is possible
    alike = {n: np.atleast_1d(getattr(choices, n))[:1] for n in OF_MEASURING}
    given = _combine(replace(choices, **alike, **others))
    given = of_possible_scales(given)
    fill = model_fill(given, model, frame.principal_distance, max_height)
    columns = _flown(given, fill.is_possible)
    columns |= work_for_each_km2(columns, frame, model)
    part = ON_LAYOUTS if frame.shares_control else 1.0
    is_densified = are_densified(columns, part)
    return bool((is_densified & fits_in(columns, frame.extent, model)).any())


def _flown(given, is_possible):
    """Columns of the combinations that are possible, with the scale flown above."""
    columns = {name: values[is_possible] for name, values in given.items()}
    high_over_low = columns.pop("high_over_low")
    columns["high_scale_number"] = high_over_low * columns["scale_number"]
    return columns


def _precisions(given, frame, model, does):
    """Precisions of the combinations with points enough that fly low enough."""
    distance = checked_number("principal_distance", frame.principal_distance)
    fill = model_fill(given, model, distance, frame.max_height)
    if not fill.is_possible.any():
        raise too_few_points(fill, given, model, frame.max_height, does)
    columns = _flown(given, fill.is_possible)
    n_points = model.n_points(columns["scale_number"], columns["spacing"])
    m_g = m_g_of_mean(columns["m_g_um"], columns["n_settings"]) * METRES_PER_UM
    parts = _expected(columns, m_g, frame, model)
    planned = planned_precision(
        columns["scale_number"], columns["spacing"], parts.approximate, m_g, model
    )
    n_coverages = columns["n_coverages"]
    mean = mean_of_coverages(planned.M_centre, planned.M_edge, n_coverages)
    columns |= {
        **flown_columns(columns, distance, frame.sampled_um),
        "n_points": n_points,
        "m_0": parts.approximate,
        "M_centre": planned.M_centre,
        "M_edge": planned.M_edge,
        "M_mean": mean,
        **{f"expected_{place}": getattr(parts, place) for place in EXPECTED},
    }
    columns["limited_by"] = _limits(parts)
    return columns


def _expected(columns, m_g, frame, model) -> ExpectedParts:
    """Expectation of all combinations; the control's pattern is no number."""
    found = {}
    for pattern in (5, 9):
        flights = FlightsToExpect(
            scale_number=columns["scale_number"],
            high_scale_number=columns["high_scale_number"],
            spacing=columns["spacing"],
            m_g=m_g,
            high_m_g=frame.high_over_low_m_g * m_g,
            n_coverages=columns["n_coverages"],
            control_error=frame.control_standard_error,
            control_per_model=pattern,
        )
        found[pattern] = expected_parts(flights, model)
    is_nine = columns["control_per_model"] == 9
    five, nine = vars(found[5]), vars(found[9])
    return ExpectedParts(**{n: np.where(is_nine, nine[n], five[n]) for n in five})


def _limits(parts):
    sizes = np.stack([getattr(parts, name) for name in LIMITS])
    return np.array(list(LIMITS), dtype=object)[np.argmax(sizes, axis=0)]


def _reached(columns, where, by):
    """Error at the place of the target, of what is delivered."""
    error = "M" if by == "paper" else "expected"
    centre, edge, mean = (columns[f"{error}_{p}"] for p in ("centre", "edge", "mean"))
    # the rule of the paper knows no corner
    worst = np.maximum(centre, edge if by == "paper" else columns["expected_corner"])
    single = {"centre": centre, "edge": edge, "everywhere": np.maximum(worst, edge)}
    reached = np.where(columns["n_coverages"] == 1, single[where], mean)
    # models that do not determine their edge promise nothing
    return np.where(np.isfinite(np.maximum(centre, edge)), reached, np.inf)
