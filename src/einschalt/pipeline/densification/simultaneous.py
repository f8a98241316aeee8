"""The simultaneous adjustment of a block: both flights and the control at once."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal

import numpy as np
import pandas as pd

from einschalt.foundations.arguments import (
    described,
    finite_number,
    is_choice,
    require_choice,
    require_kind,
)
from einschalt.foundations.errors import GeometryError, SettingsError, TableError
from einschalt.foundations.frame_columns import with_columns
from einschalt.pipeline.block.block import Block, with_errors_as_shown
from einschalt.stages.curved_earth import bend_flights
from einschalt.stages.error_propagation.given_points import CONTROL_POINTS
from einschalt.stages.error_propagation.shared_error import (
    shared_error_of,
    with_shared_columns,
)
from einschalt.stages.relative_orientation.image_errors import ImageErrors
from einschalt.stages.relative_orientation.parallax_errors import OrientationErrors
from einschalt.stages.simultaneous.adjustment import (
    DEFORMATIONS,
    AdjustmentOptions,
    BlockAdjustment,
    simultaneous_adjustment,
    with_known_groups,
)
from einschalt.stages.simultaneous.determined_part import determined_part, placed_points
from einschalt.stages.simultaneous.image_errors import MeasuredImages, centres_behind
from einschalt.stages.simultaneous.observations import (
    CENTRE,
    SPATIAL,
    BlockTables,
    MeasuredFlight,
    code_block,
)
from einschalt.stages.simultaneous.own_deformation import (
    estimate_beside_control,
    estimate_for,
    is_detected,
    sampled_part,
    with_errors_that_show,
)
from einschalt.stages.simultaneous.searches import Searches
from einschalt.stages.simultaneous.shared_control import SharedErrors
from einschalt.stages.stage2_relative_orientation import (
    RelativeOrientation,
    relative_orientation,
)
from einschalt.stages.stage4_error_propagation import CONTROL_UNKNOWN
from einschalt.theory.adjustment.significance import GROSS_ERROR_SIGNIFICANCE
from einschalt.theory.block_adjustment.common_parameters import (
    AFFINITY,
    DEGREE,
    CommonTerms,
)
from einschalt.theory.block_adjustment.spatial_solution import NoConvergenceError

FILM_AFFINITY = "helmert_film_affinity"
MODEL_PLANE = ("x", "y")
PLANE_KINDS = ("affine", "helmert")
# height over plan to begin with: c / b of a wide-angle camera at 60 per cent overlap
HEIGHT_OVER_PLAN = 1.65
# projection centres over points of a model, to begin with
CENTRE_OVER_POINT = 3.0
STANDARD_ERRORS = [
    *("standard_error_easting", "standard_error_northing", "covariance_en"),
    *("standard_error_total", "standard_error_height"),
    *("covariance_eh", "covariance_nh"),
]
DIFFERENCES = ["difference_easting", "difference_northing", "difference_height"]
ADJUSTED_KINDS = ("affine", "helmert", FILM_AFFINITY, SPATIAL)
WHICH = {
    "both": ("high_flight", "low_flight"),
    "high": ("high_flight",),
    "low": ("low_flight",),
}
# a similarity without scale is bent as one with it
ADJUSTED_AS = {"rigid": "helmert"}
MODELLED = "modelled"


def adjust_block(
    block: Block,
    *,
    kind: Literal[
        "affine", "helmert", "helmert_film_affinity", "helmert_3d"
    ] = "affine",
    flights: Literal["both", "high", "low"] = "both",
    deformation: str | Sequence[str] = (),
    outliers: Literal["keep", "snoop", "huber", "tukey"] = "keep",
    significance: float = GROSS_ERROR_SIGNIFICANCE,
    variance_components: Literal["given", "estimated"] = "given",
) -> BlockAdjustment:
    """Adjust all models of a block with its control at once.

    Every measured coordinate is an observation with the standard error m_g · scale
    number / √2 on the ground, smaller by the root of its settings; every control point
    is an observation with its own standard error, or held where it has none. Check
    points are adjusted as new points, and compared. Standard errors of points contain
    the error that all control shares (``block.shared_errors_m``). Control that shares
    errors of a group, or over a distance, is weighed as if each point had them for
    itself: standard errors hold what they share, but the points are not those of least
    variance (one block with 10 cm per group: 9.5 cm, 7.6 cm with all covariances).

    Parameters
    ----------
    block : Block
    kind : {"affine", "helmert", "helmert_film_affinity", "helmert_3d"}
        Transformation of every model; helmert_film_affinity is helmert with one film
        affinity that all models of a flight share, helmert_3d has seven parameters and
        gives heights. Where model points come from images, projection centres tie the
        models as well (``centres``).
    flights : {"both", "high", "low"}
    deformation : sequence of {"quadratic", "cubic"}, or "modelled" or "tested"
        Deformations of the model that all models of a flight share: these; or those
        that a test finds; or none, but the test is made (``deformations``).
    outliers : {"keep", "snoop", "huber", "tukey"}
        What happens to gross errors: they are only named, taken out, or given less
        weight. Control that contradicts the block is only named with "keep", and set
        aside otherwise.
    significance : float
        Probability with which a model without gross errors has a suspect.
    variance_components : {"given", "estimated"}
        Whether control and flights have the errors that were given, or those that
        their residuals show (``components``; with "given" its factors are one step
        towards these only). Heights of spatial models always have the latter.

    Returns
    -------
    BlockAdjustment
        ``points``, ``models``, ``residuals``, ``control``, ``s_0``, ``failures``, …

    Raises
    ------
    GeometryError
        Nothing of the block can be determined.
    SettingsError
        An option is unknown, or the block has no such flight.
    """
    require_kind("block", block, Block, expected="a Block (einschalt.read_block)")
    require_choice("kind", kind, ADJUSTED_KINDS)
    require_choice("flights", flights, tuple(WHICH))
    searched, given = _deformation(deformation)
    significance = _probability(significance)
    measured = {n: flight for n, flight in block.flights.items() if n in WHICH[flights]}
    if not measured:
        raise SettingsError(
            f"flights = {flights!r}, but the block has no {flights} flight",
            expected=" or ".join(n.removesuffix("_flight") for n in block.flights),
        )
    families = (*((AFFINITY,) if kind == FILM_AFFINITY else ()), *given)
    options = AdjustmentOptions(
        common=common_terms(measured, families),
        outliers=outliers,
        significance=significance,
        deformation=searched,
        variance_components=variance_components,
    )
    _require_control(block)
    # all that can be wrong with the call is said before the work begins
    oriented = {name: relative_orientation(f) for name, f in measured.items()}
    if kind == SPATIAL:
        _require_spatial(block, oriented, given)
    kinds = dict.fromkeys(measured, "helmert" if kind == FILM_AFFINITY else kind)
    block = with_errors_as_shown(block, outliers)
    if block.settings.earth_curvature == "treated":
        oriented = bend_for_adjustment(block, oriented, kinds)
    adjusted = simultaneous_adjustment(block_tables(block, oriented, kinds), options)
    shared_error = shared_error_of(block, "simultaneous")
    points = with_shared_columns(adjusted.points, shared_error)
    return _with_check_points(replace(adjusted, points=points), block.control_points)


def _with_check_points(adjusted, given):
    """The adjustment that says which of its points are check points, and how far off.

    By adjusted less given coordinates [m].
    """
    points = adjusted.points
    checks = given[given["role"] == "check"].set_index("point_id")
    place = checks.index.get_indexer(points["point_id"])
    rows = np.flatnonzero(place >= 0)
    if not len(rows):
        return adjusted
    columns = {"role": points["role"].to_numpy(dtype=object, copy=True)}
    columns["role"][rows] = "check"
    for difference in DIFFERENCES:
        name = difference.removeprefix("difference_")
        if difference in points and name in checks:
            columns[difference] = points[difference].to_numpy(copy=True)
            known = checks[name].to_numpy()[place[rows]]
            columns[difference][rows] = points[name].to_numpy()[rows] - known
    return replace(adjusted, points=with_columns(points, **columns))


def _deformation(value):
    """What to do about deformations, and the families that are given."""
    families = tuple(DEGREE)
    expected = f"{' or '.join(DEFORMATIONS)}, or a list of {' or '.join(families)}"
    if isinstance(value, str) and value not in families:
        if value not in DEFORMATIONS:
            raise SettingsError(
                f"deformation = {described(value)} is unknown", expected=expected
            )
        return value, ()
    require_kind("deformation", value, str | list | tuple, expected=expected)
    given = (value,) if isinstance(value, str) else tuple(value)
    for family in given:
        if not is_choice(family, families):
            raise SettingsError(
                f"deformation = {described(family)} is unknown", expected=expected
            )
    return "ignored", tuple(dict.fromkeys(given))


def _probability(value):
    expected = "a probability above 0 and below 1"
    number = finite_number("significance", value, expected=expected)
    if not 0.0 < number < 1.0:
        raise SettingsError(f"significance = {number:g}", expected=expected)
    return number


def require_adjustable(block):
    """Refuse blocks without control, and models that are not adjusted at once."""
    _require_control(block)
    kinds = {name: flight.transformation for name, flight in block.flights.items()}
    allowed = (*PLANE_KINDS, SPATIAL)
    for name, kind in kinds.items():
        if kind not in allowed:
            raise SettingsError(
                f'[{name}] transformation = {kind!r} with method = "simultaneous"',
                expected=" or ".join(allowed),
                remedy='Write one of these, or set method = "two_step"',
            )
    if SPATIAL in kinds.values() and len(set(kinds.values())) > 1:
        said = ", ".join(f"[{name}] {kind}" for name, kind in kinds.items())
        raise SettingsError(
            f"spatial and plane models in one adjustment: {said}",
            expected="the same kind of models in both flights",
            remedy=f'Write transformation = "{SPATIAL}" in both, or a plane one in '
            'both, or set method = "two_step"',
        )


def _require_spatial(block, oriented, deformation):
    """Refuse plane tables, and what plane models alone can have."""
    if deformation:
        raise SettingsError(
            f"deformation = {deformation!r} with kind = {SPATIAL!r}",
            expected="no deformation of spatial models",
            remedy="Leave it out, or take a plane kind",
        )
    lacking = [name for name, o in oriented.items() if "z" not in o.model_points]
    if lacking or "height" not in block.control_points:
        where = lacking or ["control_points"]
        raise SettingsError(
            f"kind = {SPATIAL!r}, but {' and '.join(where)} "
            f"{'have' if len(where) > 1 else 'has'} no heights",
            expected="z of all model points, and heights of control",
            remedy="Give them, or take a plane kind",
        )


def _require_control(block):
    control = block.control_points
    if control is None or not (control["role"] != "check").any():
        raise SettingsError(
            "the block has no control points",
            expected="control_points that hold the adjusted models",
            remedy='Give control_points, or set method = "two_step"',
        )


@dataclass(frozen=True, eq=False)
class SearchedFlights:
    """Flights of a block, adjusted together for one purpose after the other.

    Gross errors are looked for where a flight hangs together, and again where all
    flights are adjusted: in a block of one flight this is the same.
    """

    block: Block
    flights: dict[str, RelativeOrientation]
    searches: Searches  # what the adjustments share

    @cached_property
    def tables(self) -> BlockTables:
        """Observations of the flights."""
        kinds = {name: self.block.flights[name].transformation for name in self.flights}
        return block_tables(self.block, self.flights, kinds)

    def are_of(self, block: Block, flights: dict[str, RelativeOrientation]) -> bool:
        """Whether they are these flights of this block, and no others."""
        return (
            self.block is block
            and self.flights.keys() == flights.keys()
            and all(self.flights[name] is flights[name] for name in flights)
        )

    def adjusted(self, options: AdjustmentOptions) -> BlockAdjustment:
        """Adjust the flights; errors as of :func:`simultaneous_adjustment`."""
        return simultaneous_adjustment(self.tables, options, self.searches)


def searched_flights(block, flights, known=None) -> SearchedFlights:
    """Flights of a block, as they are known if these are the same.

    Only of a block of one flight do its adjustments share anything.
    """
    if known is not None and known.are_of(block, flights):
        return known
    return SearchedFlights(block, flights, Searches(are_kept=len(flights) == 1))


def adjust_flights(block, settings, flights, searched=None):
    """Adjust all flights of a block, after stage 2, as its settings say.

    ``searched`` are SearchedFlights that may be these.
    """
    options = AdjustmentOptions(
        outliers=settings.outliers,
        significance=settings.significance,
        deformation=settings.model_deformation,
        variance_components=settings.variance_components,
    )
    return searched_flights(block, flights, searched).adjusted(options)


def bend_for_adjustment(block, flights, kinds=None):
    """Bend the models of all flights as the map is bent, before they are adjusted.

    Models without enough known points of their own are placed by an adjustment of all.
    ``kinds`` of each flight as they are adjusted, where the block does not state them.
    """
    kinds = kinds or {name: block.flights[name].transformation for name in flights}

    def place(bent):
        if len(set(kinds.values())) > 1:
            return None
        try:
            _require_control(block)
            return placed_points(block_tables(block, bent, kinds))
        except (SettingsError, GeometryError, TableError, NoConvergenceError):
            return None  # the adjustment itself says why

    return bend_flights(block, flights, kinds, place=place)


def unknown_error(block, errors, tables):
    """Say which source of error has a size that the adjustment does not know.

    ``errors`` are those of the orientations of each flight, ``tables`` those that were
    adjusted.
    """
    if "standard_error_m" not in block.control_points:
        return CONTROL_UNKNOWN
    if tables.has_unknown_groups:
        return "shifts of groups of control have no group_error_m, and do not show"
    flights = block.flights
    is_oriented = [
        name
        for name, flight in flights.items()
        if flight.is_oriented_numerically and not flight.has_images
    ]
    if any(flights[name].transformation == SPATIAL for name in is_oriented):
        return "the effect of the errors of orientations on heights is unknown"
    if not all(isinstance(errors[name], OrientationErrors) for name in is_oriented):
        return (
            "y-parallaxes without redundancy do not show the errors of the orientations"
        )
    return ""


def distribute_adjusted(block, settings, points):
    """Distribute the residuals of control, where the settings ask for it.

    Then without standard errors: those of before do not hold for the points that were
    moved.
    """
    if settings.residual_distribution == "none":
        return points
    # imported where residuals are distributed: most blocks do without
    from einschalt.stages.residual_distribution import (  # noqa: PLC0415
        distribute_residuals,
    )

    moved = distribute_residuals(
        points, block.control_points, settings.residual_distribution
    ).points
    return moved.drop(columns=STANDARD_ERRORS, errors="ignore")


def common_terms(flights, families):
    """Terms that the models of each flight share."""
    if not families:
        return ()
    return tuple(CommonTerms(place, families) for place in range(len(flights)))


def block_tables(block, flights, kinds):
    """Observations of the flights that take part, after stage 2.

    With the errors of their orientations, and the projection centres that spatial
    models have in common. ``kinds`` of each flight: affine, helmert or helmert_3d.
    """
    measured = []
    for name, flight in flights.items():
        rows, shared = flight.model_points, None
        error = block.flights[name].ground_error_of(rows)
        if kinds[name] == SPATIAL:
            rows, error = _in_space(name, rows, flight.centres, error)
        elif isinstance(flight.errors, OrientationErrors):
            shared = flight.errors.factors[:, : len(MODEL_PLANE)]
        images = _images_behind(block.flights[name], flight, kinds[name])
        measured.append(MeasuredFlight(name, rows, error, kinds[name], shared, images))
    shared = SharedErrors(
        block.group_errors_m.get(CONTROL_POINTS),
        block.correlation_lengths_m.get(CONTROL_POINTS, 0.0),
    )
    return code_block(measured, block.control_points, shared)


def _images_behind(flight, oriented, kind):
    """Image points behind the model points of a flight, if it has any."""
    if not isinstance(oriented.errors, ImageErrors):
        return None
    centres = None
    if kind == SPATIAL and not oriented.centres.empty:
        centres = centres_behind(oriented.errors, oriented.centres)
    return MeasuredImages(
        oriented.errors,
        flight.ground_error_of(flight.image_points),
        flight.image_points,
        flight.scale_number,
        centres,
        flight.tails,
    )


def _in_space(name, points, centres, error):
    """Points with projection centres below them, and their errors to begin with."""
    axes = np.array([1.0, 1.0, HEIGHT_OVER_PLAN])
    errors = error[:, None] * axes
    if centres.empty:
        return points, errors
    names = ["coverage", "model_id", "point_id", "x", "y", "z"]
    # photographs of both flights may have the same names
    below = centres.assign(point_id=f"{name} " + centres["image_id"])[names]
    both = pd.concat([points[names], below], ignore_index=True)
    both[CENTRE] = np.arange(len(both)) >= len(points)
    of_centres = np.full((len(centres), 3), CENTRE_OVER_POINT * np.median(error))
    return both, np.concatenate([errors, of_centres])


def own_deformation_of(searched, settings, approximations):
    """Estimate how much models are bent for themselves, where that shows.

    All models are adjusted at once for it, or some of them in a large block. Returns
    an OwnDeformation, its flights numbered as those of ``searched`` (SearchedFlights);
    None where nothing shows, or nothing tells. ``approximations`` are the points as
    they are known by then.
    """
    block, flights = searched.block, searched.flights
    if settings.model_deformation != MODELLED or block.control_points is None:
        return None
    # errors of image points bend models too, and the propagation knows them already
    if any(flight.has_images for flight in block.flights.values()):
        return None
    given = {name: block.flights[name].transformation for name in flights}
    kinds = {name: ADJUSTED_AS.get(kind, kind) for name, kind in given.items()}
    if "helmert_3d" in kinds.values() and len(set(kinds.values())) > 1:
        return None
    try:
        is_same = kinds == given
        tables = searched.tables if is_same else block_tables(block, flights, kinds)
        tables = with_known_groups(tables, settings.significance)
        part, _ = determined_part(tables)
    # control cannot hold all models at once
    except (GeometryError, TableError, NoConvergenceError):
        return None
    names = tables.point_id[part.points]
    axes = ["easting", "northing", *(["height"] if tables.is_spatial else [])]
    known = approximations.set_index("point_id").reindex(columns=axes)
    places = known.reindex(names).to_numpy(dtype=float)
    sample = sampled_part(part, places)
    try:
        if tables.is_spatial:
            sample = with_errors_that_show(tables, sample)
        estimate = estimate_for if block.high_flight else estimate_beside_control
        own = estimate(tables, sample, _shared_terms(tables, sample, kinds))
    except NoConvergenceError:
        return None
    return own if is_detected(own) else None


def _shared_terms(tables, part, kinds):
    """What models of a flight may share, which none of them has for itself."""
    if tables.is_spatial:
        return ()
    affine, others = tuple(DEGREE), (AFFINITY, *DEGREE)
    return tuple(
        CommonTerms(k, affine if kinds[name] == "affine" else others)
        for k, name in enumerate(tables.flights)
        if (part.observations.flight == k).any()
    )
