"""Patterns that errors of measuring do not make: affinity of film, strain of control.

The affinity common to the models of a flight is tested against the errors of control
and measurements, carried through every stage. Strain is looked for in the corrections
of the control points when all models of both flights are adjusted together with them,
since the residuals of five control points in a model hardly show it.
"""

from dataclasses import dataclass, field
from functools import cached_property, partial

import numpy as np
import pandas as pd
from scipy.special import chdtrc

from einschalt.foundations.frame_columns import values_of
from einschalt.foundations.names import encode, encode_pairs, is_among
from einschalt.pipeline.assessment.evidence.control.signatures import covariance_of
from einschalt.pipeline.assessment.evidence.fits.film_affinity import (
    FilmAffinity,
    affinities_on_ground,
    film_affinity,
)
from einschalt.pipeline.assessment.evidence.without_gross_errors import (
    gross_rows,
)
from einschalt.pipeline.assessment.plain_values import IS_PLAIN
from einschalt.stages.error_propagation.error_model import CONTROL
from einschalt.stages.error_propagation.measurement_errors import ORIENTATION
from einschalt.theory.adjustment.point_operator import Axes, selection
from einschalt.theory.adjustment.significance import SYSTEMATIC_SIGNIFICANCE
from einschalt.theory.adjustment.smooth_pattern import smooth_pattern
from einschalt.theory.block_adjustment.common_parameters import (
    affinity_on_ground,
    polynomials_on_ground,
)
from einschalt.theory.block_adjustment.control_information import (
    ControlValues,
    ModelValues,
    control_checks,
    with_shared_errors,
)

SURELY_NOT_SCALED = 0.05
# beyond these the adjustment of everything takes longer than a look at a result should
MOST_MODELS, MOST_CONTROL = 20_000, 1500
N_CURVED = 7  # quadratic and cubic terms


@dataclass(frozen=True)
class CommonCurvature:
    """Quadratic and cubic terms that the models of a flight have in common."""

    flight: str
    size: float  # displacement of the points by them, TOTAL, root mean square [m]
    p_value: float  # joint test of all terms

    @property
    def is_significant(self) -> bool:
        """Whether chance does not explain it."""
        return bool(self.p_value < SYSTEMATIC_SIGNIFICANCE)


@dataclass(frozen=True, eq=False)
class ControlScores:
    """What the adjustment of everything knows of the errors of control points."""

    places: np.ndarray  # rows of the table of control
    values: np.ndarray  # shape (n, 2); weight times error [1/m]
    information: np.ndarray  # shape (n, n); of either coordinate [1/m²]

    def without(self, is_free: np.ndarray) -> "ControlScores":
        """The same of the others, where some, (n,), may be as wrong as they like."""
        kept, free = self.information[~is_free], self.information[is_free]
        share = np.linalg.lstsq(free[:, is_free], free[:, ~is_free], rcond=None)[0].T
        return ControlScores(
            self.places[~is_free],
            self.values[~is_free] - share @ self.values[is_free],
            kept[:, ~is_free] - share @ free[:, ~is_free],
        )

    def beside(self, pattern: np.ndarray) -> "ControlScores":
        """The same beside a pattern of displacements (n,) of whatever amplitude."""
        shown = self.information @ pattern
        known = float(shown @ pattern)
        if not known > 0.0:
            return self
        return ControlScores(
            self.places,
            self.values - np.outer(shown, pattern @ self.values) / known,
            self.information - np.outer(shown, shown) / known,
        )


@dataclass(frozen=True, eq=False)
class NetworkStrain:
    """A pattern in the errors of the control points."""

    size: float  # TOTAL, root mean square [m]
    reach: float  # distance over which the displacements keep their direction [m]
    p_value: float  # of the test against errors of the given sizes
    is_smooth: bool  # whether larger errors of single points do not explain it as well
    n_control: int
    # point_id, easting, northing of the displacement of each control point as it is
    # estimated [m], the largest first; without what is common to all of them, which
    # is not seen
    displacements: pd.DataFrame
    # twice the logarithm, of the pattern against none
    likelihood_ratio: float = field(
        default=np.nan, repr=False, metadata={IS_PLAIN: False}
    )
    # that it was found in
    scores: ControlScores | None = field(
        default=None, repr=False, metadata={IS_PLAIN: False}
    )

    @property
    def is_significant(self) -> bool:
        """Whether chance does not explain it."""
        return bool(self.p_value < SYSTEMATIC_SIGNIFICANCE)


@dataclass(frozen=True)
class SystematicPatterns:
    """What was looked for in a block."""

    affinities: tuple[FilmAffinity, ...]  # of the flights, as far as they can be tested
    # None where the control points do not check each other, or are too many
    strain: NetworkStrain | None
    # of the flights, where it is likelier than a strain
    curvatures: tuple[CommonCurvature, ...] = field(
        default=(), metadata={IS_PLAIN: False}
    )

    @property
    def scores(self) -> "ControlScores | None":
        """What all models know of the control points: ControlScores, or None."""
        return None if self.strain is None else self.strain.scores


def find_patterns(examined):
    """Look for affinity of film and for strain of the control points.

    With measuring errors of the sizes that the block shows, where it shows any. None
    where the errors of the block cannot be propagated.
    """
    block, model, components = examined.block, examined.propagation, examined.components
    if model is None or model.high is None or model.axes is Axes.SPACE:
        return SystematicPatterns((), None)
    errors = dict(model.standard_errors)
    for flight in block.flights if components is not None else ():
        component = getattr(components, flight)
        # nearly nothing says that the block is too small to tell
        if component.estimated > component.standard_error:
            errors[flight] = errors[flight] * component.estimated / component.given
    fits = {"high_flight": examined.high.transformation, "low_flight": examined.low}
    affinities = (film_affinity(flight, fits[flight], model, errors) for flight in fits)
    found = tuple(part for part in affinities if part is not None)
    # what film does to models must not pass for a strain of the network
    affine = {part.flight for part in found if part.is_absorbed or part.is_significant}
    # orientations bend models: what that makes would pass for strain
    strain, curvatures = None, ()
    has_images = any(flight.has_images for flight in block.flights.values())
    is_bent = ORIENTATION in errors or has_images
    if not is_bent and not beyond_strain_test(examined):
        strain, curvatures, on_ground = _strain(examined, fits, errors, affine)
        found = tuple(on_ground.get(part.flight, part) for part in found)
    return SystematicPatterns(found, strain, curvatures)


def strain_without(examined, wrong):
    """The strain of the control points beside those that are ``wrong`` by themselves.

    Names of points; None where the others do not check each other, or nothing was
    looked for. A single wrong point would pass for a strain of its neighbours.
    """
    strain = examined.patterns.strain
    if strain is None or not wrong:
        return strain
    scores, control = strain.scores, examined.block.control_points
    names = control["point_id"].to_numpy(dtype=object)[scores.places]
    is_free = np.isin(names, list(wrong))
    if not is_free.any():
        return strain
    return _strain_of(scores.without(is_free), control)


def strain_beside(strain, point_ids, control):
    """The strain that is left beside a shift of some points, which may be as it likes.

    None where nothing tells.
    """
    names = control["point_id"].to_numpy(dtype=object)[strain.scores.places]
    pattern = np.isin(names, list(point_ids)).astype(float)
    return _strain_of(strain.scores.beside(pattern), control)


def beyond_strain_test(examined):
    """Say what makes a block too large for the test of strain, if anything."""
    control = examined.block.control_points
    n_control = 0 if control is None else int((control["role"] != "check").sum())
    if n_control > MOST_CONTROL:
        return f"{n_control} control points, at most {MOST_CONTROL}"
    if len(examined.models) > MOST_MODELS:
        return f"{len(examined.models)} models, at most {MOST_MODELS}"
    return ""


def _strain(examined, transformations, errors, affine):
    """NetworkStrain or None, and what of models is likelier.

    Curvatures of the flights, and affinities along the axes of the ground by flight.
    """
    block, bent = examined.block, examined.own_deformation
    control = block.control_points
    is_used = (control["role"] != "check").to_numpy()
    is_used = is_used & ~is_among(control["point_id"], examined.excluded_control)
    tables = {name: examined.model_points[name] for name in transformations}
    held = pd.concat([table["point_id"] for table in tables.values()])
    # what no model holds says nothing, and may lie anywhere
    is_held = is_among(control["point_id"], held)
    is_used = is_used & is_held
    names = encode(pd.concat([control["point_id"], held]))
    n_control = len(control)
    origin = values_of(control, ["easting", "northing"])[is_held].mean(axis=0)
    flights, films, first = [], {}, n_control
    for number, (name, transformation) in enumerate(transformations.items()):
        table = tables[name]
        codes = names.codes[first : first + len(table)]
        first += len(table)
        is_out = gross_rows(examined, name, transformation)
        values = FlightValues.of(transformation, table, codes, errors[name], is_out)
        displaced = values.displaced(bent, number)
        how = {"is_affine": name in affine, "may_be_curved": True}
        flights.append(values.about(origin, displaced, **how))
        films[name] = transformation, values.of_affinity, name not in affine
    xy = values_of(control, ["easting", "northing"])[is_used] - origin
    given = ControlValues(
        names.codes[:n_control][is_used],
        xy @ np.array([1.0, 1j]),
        errors["control"][is_used] ** -2.0,
    )
    shared = None
    if examined.shares_control_errors:
        shared = _shared(examined.propagation.high.control, errors, is_used)
    checks, places = control_checks(flights, given), np.flatnonzero(is_used)
    scores_of = partial(_scores, checks, places, shared)
    return _likelier(checks.common, scores_of, control, flights, films)


def _likelier(common, scores_of, control, flights, films):
    """What ``_strain`` gives, of scores of control, which models may share terms in."""
    strain = _strain_of(scores_of(), control)
    if strain is None:
        return strain, (), {}
    is_curved = np.concatenate(
        [np.arange(flight.common.shape[1]) < N_CURVED for flight in flights]
    )
    curved, stretched = (common.only(some) for some in (is_curved, ~is_curved))
    # models that are curved alike make a block that is curved, and control with it
    if strain.likelihood_ratio < curved.likelihood_ratio:
        strain = _strain_of(scores_of(curved), control)
        return strain, _curvatures(curved, flights, tuple(films)), {}
    # so do models that are longer one way, where no strain is left beside them
    on_ground = affinities_on_ground(stretched, films) if strain.is_significant else {}
    if on_ground:
        left = _strain_of(scores_of(stretched), control)
        if left is None or not left.is_significant:
            return left, (), on_ground
    return strain, (), {}


def _curvatures(found, flights, names):
    """CommonCurvature of each flight."""
    curvatures = []
    for number, (values, name) in enumerate(zip(flights, names, strict=True)):
        own = slice(number * N_CURVED, (number + 1) * N_CURVED)
        displaced = values.common[:, :N_CURVED] @ found.coefficients[own]
        size = np.sqrt(np.mean(np.abs(displaced) ** 2))
        p_value = chdtrc(2 * N_CURVED, found.square_of(own))
        curvatures.append(CommonCurvature(name, float(size), float(p_value)))
    return tuple(curvatures)


def _scores(checks, places, shared, free=None):
    """ControlScores of what is known of control, with what its errors ``shared``."""
    scores, information = checks.written_out(free)
    scores = np.column_stack([scores.real, scores.imag])
    if shared is not None:
        scores, information = with_shared_errors(scores, information, shared)
    return ControlScores(places, scores, information)


def _strain_of(scores, control):
    """NetworkStrain that scores of control show; None without redundancy."""
    xy = values_of(control, ["easting", "northing"])[scores.places]
    xy = xy - xy.mean(axis=0)
    found = smooth_pattern(scores.values, scores.information, xy)
    if not np.isfinite(found.p_value):
        return None
    moved = pd.DataFrame(found.field, columns=["easting", "northing"])
    moved.insert(0, "point_id", control["point_id"].to_numpy()[scores.places])
    order = np.argsort(-np.hypot(moved["easting"], moved["northing"]), kind="stable")
    return NetworkStrain(
        float(np.sqrt(2.0) * found.size),
        found.reach,
        found.p_value,
        is_smooth=found.p_value_if_scaled < SURELY_NOT_SCALED,
        n_control=len(scores.places),
        displacements=moved.iloc[order].reset_index(drop=True),
        likelihood_ratio=found.likelihood_ratio,
        scores=scores,
    )


def _shared(control, errors, is_used):
    """What control has in common by what was stated, (n, n) of one coordinate [m²]."""
    axes = control.chains[CONTROL].axes
    pick = selection(np.flatnonzero(is_used), len(is_used), axes)
    n = is_used.sum()
    whole = covariance_of(control.picked(pick).chains, errors, (0,))[:n, :n]
    return whole - np.diag(errors[CONTROL][is_used] ** 2)


@dataclass(frozen=True, eq=False)
class FlightValues:
    """Values of a flight for the adjustment of everything, without gross errors."""

    xy: np.ndarray
    model: np.ndarray
    point: np.ndarray
    ground: np.ndarray
    weight: np.ndarray

    @classmethod
    def of(cls, transformation, model_points, point, errors, is_out):
        """Take those of usable models that are not ``is_out``.

        ``point`` has a number for the point of each row, ``errors`` are those of one
        coordinate [m].
        """
        values = transformation.own_values
        ground = values_of(values, ["easting", "northing"])
        rows = np.isfinite(ground).all(axis=1) & ~is_out
        names = encode_pairs(values["coverage"][rows], values["model_id"][rows])
        xy = values_of(model_points, ["x", "y"])[rows]
        return cls(xy, names.codes, point[rows], ground[rows], errors[rows] ** -2.0)

    def displaced(self, bent, number):
        """Displacements by own deformations of a flight, (n_values, n_terms)."""
        if bent is None:
            return np.zeros((len(self.xy), 0))
        return bent.displacements(number, self.xy, self.model)[0]

    def about(self, origin, displaced, *, is_affine, may_be_curved=False):
        """Values about an origin, for the adjustment of everything.

        All models may be curved alike: by quadratic and cubic terms.
        """
        value = (self.ground - origin) @ np.array([1.0, 1j])
        design = _design(self.xy, self.model, is_affine=is_affine)
        common = self.curved() if may_be_curved else np.zeros((len(value), 0))
        if may_be_curved and not is_affine:
            common = np.column_stack([common, self.of_affinity * self.stretched()])
        return ModelValues(
            design, self.model, self.point, value, self.weight, displaced, common
        )

    @cached_property
    def of_affinity(self):
        """Affinity by which the edge of a model is off by one error of measuring."""
        error = np.median(self.weight) ** -0.5
        reach = np.zeros(self.model.max() + 1)
        np.maximum.at(reach, self.model, np.abs(self.stretched()))
        reach = float(np.median(reach))
        return error / reach if reach > 0.0 else 0.0

    def stretched(self):
        """Displacements by an affinity of 1 that models share on the ground, (n,)."""
        return affinity_on_ground(self.model, self.ground)

    def curved(self):
        """Displacements by polynomials that the models share, complex (n, n_terms).

        At the edge of a model they are as large as an error of measuring.
        """
        error = np.median(self.weight) ** -0.5
        return polynomials_on_ground(self.xy, self.model, self.ground, error)


def _design(xy, model, *, is_affine):
    """Columns of about unit size; a rigid model may turn and stretch, like helmert."""
    count = np.bincount(model)
    centre = np.column_stack([np.bincount(model, part) / count for part in xy.T])
    offset = xy - centre[model]
    size = np.sqrt(np.bincount(model, np.sum(offset**2, axis=1)) / count)
    offset = offset / np.where(size > 0.0, size, 1.0)[model, None]
    one = np.ones(len(xy))
    if is_affine:
        return np.column_stack([one, offset])
    return np.column_stack([one, offset @ np.array([1.0, 1j])])
