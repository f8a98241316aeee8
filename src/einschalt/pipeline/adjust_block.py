"""All models of the flights of a block in one adjustment, with the control."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Literal

import numpy as np

from einschalt.foundations.arguments import (
    described,
    finite_number,
    is_choice,
    require_choice,
    require_kind,
)
from einschalt.foundations.errors import SettingsError
from einschalt.foundations.frame_columns import with_columns
from einschalt.pipeline.block.block import Block, with_errors_as_shown
from einschalt.pipeline.densification.simultaneous import (
    DIFFERENCES,
    bend_for_adjustment,
    block_tables,
    common_terms,
    require_control,
)
from einschalt.stages.error_propagation.shared_error import (
    shared_error_of,
    with_shared_columns,
)
from einschalt.stages.simultaneous.adjustment import (
    DEFORMATIONS,
    AdjustmentOptions,
    BlockAdjustment,
    simultaneous_adjustment,
)
from einschalt.stages.stage2_relative_orientation import relative_orientation
from einschalt.stages.transformation_kinds import SPATIAL
from einschalt.theory.adjustment.significance import GROSS_ERROR_SIGNIFICANCE
from einschalt.theory.block_adjustment.common_parameters import AFFINITY, DEGREE

FILM_AFFINITY = "helmert_film_affinity"
ADJUSTED_KINDS = ("affine", "helmert", FILM_AFFINITY, SPATIAL)
WHICH = {
    "both": ("high_flight", "low_flight"),
    "high": ("high_flight",),
    "low": ("low_flight",),
}


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
    require_control(block)
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
