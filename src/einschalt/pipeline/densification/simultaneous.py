"""The simultaneous adjustment of a block: both flights and the control at once."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pandas as pd

from einschalt.foundations.errors import GeometryError, SettingsError, TableError
from einschalt.pipeline.block.block import Block
from einschalt.stages.curved_earth import bend_flights
from einschalt.stages.error_propagation.given_points import CONTROL_POINTS
from einschalt.stages.relative_orientation.image_errors import ImageErrors
from einschalt.stages.relative_orientation.parallax_errors import OrientationErrors
from einschalt.stages.simultaneous.adjustment import (
    AdjustmentOptions,
    BlockAdjustment,
    simultaneous_adjustment,
    with_known_groups,
)
from einschalt.stages.simultaneous.determined_part import determined_part, placed_points
from einschalt.stages.simultaneous.image_errors import MeasuredImages, centres_behind
from einschalt.stages.simultaneous.observations import (
    CENTRE,
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
)
from einschalt.stages.stage4_error_propagation import CONTROL_UNKNOWN
from einschalt.stages.transformation_kinds import SPATIAL
from einschalt.theory.block_adjustment.common_parameters import (
    AFFINITY,
    DEGREE,
    CommonTerms,
)
from einschalt.theory.block_adjustment.spatial_solution import NoConvergenceError

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
# a similarity without scale is bent as one with it
ADJUSTED_AS = {"rigid": "helmert"}
MODELLED = "modelled"


def require_adjustable(block):
    """Refuse blocks without control, and models that are not adjusted at once."""
    require_control(block)
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


def require_control(block):
    """Refuse blocks without control that holds the models."""
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
            require_control(block)
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
