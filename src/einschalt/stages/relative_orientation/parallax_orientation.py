"""What the orientation of models by y-parallaxes gives, and what it corrects."""

import warnings
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pandas as pd

from einschalt.foundations import tables, typesetting
from einschalt.foundations.batches import segment_sum, segments
from einschalt.foundations.display_names import all_shortened, printable
from einschalt.foundations.errors import EinschaltWarning, name_some, raise_problems
from einschalt.foundations.frame_columns import values_of
from einschalt.foundations.kept_texts import place_text, retold
from einschalt.foundations.language import mark, mark_each, translated
from einschalt.foundations.names import encode_pairs
from einschalt.foundations.units import RADIANS_PER_GON
from einschalt.stages.relative_orientation.dangerous_surface import (
    ModelGeometry,
    surface_problems,
    surface_table,
)
from einschalt.stages.results import Estimates, OrientationResult, failures_table
from einschalt.theory.adjustment.least_squares import pool_standard_errors
from einschalt.theory.relative_orientation.dangerous_surfaces import examine_surfaces
from einschalt.theory.relative_orientation.deformation_error import (
    correction_derivatives,
    deformation_variance,
)
from einschalt.theory.relative_orientation.hallert import ParallaxAdjustment
from einschalt.theory.relative_orientation.model_correction import correct_model
from einschalt.theory.relative_orientation.parallax_equations import ELEMENTS

STAGE = "stage2_relative_orientation"
MOST_PRINTED = 20
WIDEST_NAME = 16
TITLES = mark_each(
    {
        "independent": "independent pair",
        "dependent_left": "dependent pair, left bundle moved",
        "dependent_right": "dependent pair, right bundle moved",
    }
)
METHOD_TITLES = mark_each(
    {
        "least_squares": "least squares",
        "krames": "Krames' formulas",
        "gruber": "Gruber's procedure, tilt over-corrected in point 5",
    }
)
AND_MORE = mark("  and {n} more")
NEGLECTED = mark(
    "model {model}: its corrections are so large that the linear equations neglect "
    "parallaxes up to {parallax}. Correct it, and measure again."
)
BESIDE_THE_BASE = mark(
    "model {model}: its points lie at x = {mean} on average, the base from 0 to "
    "{base}. Count x from the left projection centre along the base."
)
NAME_COVERAGE = "Give both tables the column coverage"
ABOVE = "a point lies at or above the projection centres, z >= 0"
APART = "rays of a point do not meet after the correction"
CHECK_PARALLAXES = "Check its y-parallaxes for a blunder"
SHIFTS = ("d_by", "d_bz")
# mean of x in bases: the overlap of two photographs lies around 0.5
MIDDLE_OF_MODEL = (0.1, 0.9)
COUNT_Z_UP = "Count z upwards from the left projection centre: points have z < 0"


@dataclass(frozen=True, eq=False, repr=False)
class ParallaxOrientation(OrientationResult):
    """Relative orientations of all models, from their y-parallaxes.

    Attributes
    ----------
    case : {"independent", "dependent_left", "dependent_right"}
    method : {"least_squares", "krames", "gruber"}
    models : DataFrame
        coverage, model_id, case, n_points, redundancy, sigma_0, base, is_usable,
        reason.
    parameters : DataFrame
        Index model_id; the corrections d_omega, d_phi_1, d_phi_2, d_kappa_1,
        d_kappa_2 or d_omega, d_phi, d_kappa, d_by, d_bz [rad, unit of the model]; NaN
        where a model could not be oriented.
    residuals : DataFrame
        [coverage,] model_id, point_id, residual (adjusted minus measured parallax),
        redundancy_number; without the models that could not be oriented.
    linearisation_error : Series
        By model_id: the largest parallax that the linear equations neglect. Where it
        reaches sigma_0, the model should be corrected and measured again.
    contradiction : DataFrame
        Index model_id; what the planes x = 0 and x = base of a six-point model say by
        themselves: w (contradiction, in the unit of the parallaxes; sigma_0 of least
        squares is |w|/√12), d_omega_0, d_omega_b, delta_omega [rad], Krames'
        fundamental points Y_0, Z_0, Y_b, Z_b (infinite or NaN where M = 0), and the
        determinants M_0, M_b, N_0, N_b. NaN for other models.
    failures : DataFrame
        coverage, model_id, stage, reason, remedy.
    adjustment : ParallaxAdjustment
        Arrays by model, in the order of ``models``.
    geometry : ModelGeometry
        Of all models, also of those that could not be oriented.
    has_coverages : bool
        Whether the parallaxes name coverages.
    """

    case: str
    method: str
    models: pd.DataFrame
    parameters: pd.DataFrame
    residuals: pd.DataFrame
    linearisation_error: pd.Series
    contradiction: pd.DataFrame
    failures: pd.DataFrame
    adjustment: ParallaxAdjustment
    geometry: ModelGeometry
    has_coverages: bool

    @cached_property
    def dangerous_surface(self) -> pd.DataFrame:
        """Whether the points of each model lie near a dangerous surface, and why.

        Index model_id; verdict (safe, weak or critical), inflation, and the other
        columns of ``dangerous_surface.surface_table``.
        """
        geometry = self.geometry
        examination = examine_surfaces(
            geometry.xyz, geometry.base, geometry.model_start, case=self.case
        )
        return surface_table(examination, self.models["model_id"])

    @property
    def sigma_0(self) -> pd.Series:
        """Standard error of one parallax, in its unit: Series by model_id.

        NaN where nothing is redundant; from six points it is itself uncertain by 71 %.
        For ``gruber`` it is that of least squares too, since the procedure's own
        residuals leave the whole contradiction in point 6.
        """
        return self._by_model("sigma_0")

    @property
    def estimates(self) -> Estimates:
        """Elements of the orientations: Estimates."""
        return Estimates(
            names=ELEMENTS[self.case],
            cofactors=self.adjustment.cofactor,
            unit_error=self.adjustment.sigma_0,
            is_usable=self.models["is_usable"].to_numpy(),
        )

    @property
    def is_usable(self) -> bool:
        """Whether any model could be oriented."""
        return bool(self.models["is_usable"].any())

    def corrected(self, model_points: pd.DataFrame) -> pd.DataFrame:
        """Model points after the bundles have been turned and shifted.

        Parameters
        ----------
        model_points : DataFrame
            [coverage,] model_id, point_id, x, y, z in the system and unit of the
            parallaxes, and any other columns. y is midway between both rays, as of a
            floating mark: that of the left ray less half of the parallax.

        Returns
        -------
        DataFrame
            The same rows and columns with corrected x, y, z, without the models that
            have no orientation.

        Raises
        ------
        TableError
            A column is missing or a value is not what it should be.

        Warns
        -----
        EinschaltWarning
            Names the models that stay out.
        """
        done = correct_model_points(self, model_points)
        if len(done.failures):
            first = done.failures.iloc[0]
            warnings.warn(
                f"{typesetting.count(len(done.failures), 'model')} left out, not "
                f"corrected: {name_some(done.failures['model_id'])}. "
                f"Model {first['model_id']}: {first['reason']}. {first['remedy']}.",
                EinschaltWarning,
                stacklevel=2,
            )
        return done.points

    def summary(self) -> str:
        """Say how many models were oriented, what is doubtful, then the numbers."""
        n_usable = int(self.models["is_usable"].sum())
        sigma_0 = pool_standard_errors(
            self.adjustment.sigma_0, self.adjustment.redundancy
        )
        done = mark(
            "Relative orientation from y-parallaxes: {n_usable} of {n:model|models} "
            "oriented"
        )
        pooled = mark("sigma_0 of one parallax, all together  {sigma_0}")
        lines = [
            translated(done, n_usable=n_usable, n=len(self.models)),
            "; ".join(map(translated, (TITLES[self.case], METHOD_TITLES[self.method]))),
            translated(pooled, sigma_0=typesetting.number(sigma_0)),
        ]
        problems = self._problems()
        if problems:
            lines += ["", translated("Problems and suggestions"), *problems]
        return "\n".join([*lines, "", _table_of_models(self)])

    def _problems(self):
        said = [
            f"{place_text('model', printable(row.model_id))}: {retold(row.reason)}. "
            f"{retold(row.remedy)}."
            for row in self.failures.itertuples()
        ]
        is_usable = self.models["is_usable"].to_numpy()
        said += surface_problems(self.dangerous_surface, is_usable)
        said += _beside_the_base(self, is_usable)
        neglected = self.linearisation_error.to_numpy()
        is_large = neglected > self.models["sigma_0"].to_numpy()
        said += [
            translated(
                NEGLECTED,
                model=printable(self.models["model_id"].iloc[place]),
                parallax=typesetting.number(neglected[place]),
            )
            for place in np.flatnonzero(is_large)
        ]
        shown = said[:MOST_PRINTED]
        lines = [typesetting.wrapped(t, first="  ", indent="    ") for t in shown]
        rest = len(said) - MOST_PRINTED
        return [*lines, translated(AND_MORE, n=rest)] if rest > 0 else lines


def _beside_the_base(orientation, is_usable):
    """Say which models do not lie around the middle of their base."""
    geometry, models = orientation.geometry, orientation.models
    count = np.maximum(np.diff(geometry.model_start), 1)
    mean = segment_sum(geometry.xyz[:, 0], geometry.model_start) / count
    part = mean / np.where(is_usable, geometry.base, 1.0)
    low, high = MIDDLE_OF_MODEL
    return [
        translated(
            BESIDE_THE_BASE,
            model=models["model_id"].iloc[place],
            mean=typesetting.number(mean[place]),
            base=typesetting.number(geometry.base[place]),
        )
        for place in np.flatnonzero(is_usable & ~((low < part) & (part < high)))
    ]


@dataclass(frozen=True, eq=False)
class CorrectedModelPoints:
    """Corrected points, and the models that stay out."""

    # the rows and columns of the given points with corrected x, y, z, without the
    # models in ``failures``
    points: pd.DataFrame
    failures: pd.DataFrame  # coverage, model_id, stage, reason, remedy
    # (n_models,): of each orientation, what an affine transformation leaves of its
    # error in the plan coordinates of these points: total, in their unit. NaN where
    # nothing was redundant, or fewer than three points were corrected
    orientation_error: np.ndarray


def correct_model_points(orientation, model_points) -> CorrectedModelPoints:
    """Correct model points, and say without a warning which models stay out."""
    checked = tables.check_table(model_points, tables.MODEL_POINTS.requiring("z"))
    raise_problems(checked.problems)
    frame = checked.frame
    asked = encode_pairs(frame["coverage"], frame["model_id"])
    has_coverages = "coverage" in model_points.columns
    faults = ModelFaults.none(len(asked))
    place = _find_models(orientation, asked.names, has_coverages, faults)
    xyz = values_of(frame, ["x", "y", "z"])
    faults.say_of_rows(asked.codes[xyz[:, 2] >= 0.0], ABOVE, COUNT_Z_UP)
    rows = np.flatnonzero(faults.is_sound[asked.codes])
    model = place[asked.codes[rows]]
    corrected = np.zeros_like(xyz)
    base = orientation.models["base"].to_numpy()[model]
    elements = orientation.adjustment.elements[model]
    corrected[rows] = correct_model(xyz[rows], base, elements, orientation.case)
    error = _orientation_error(orientation, xyz[rows], model)
    # rays that part meet above the centres, or nowhere
    is_apart = ~(corrected[:, 2] < 0.0)
    faults.say_of_rows(asked.codes[is_apart], APART, CHECK_PARALLAXES)
    frame = frame.assign(**dict(zip("xyz", corrected.T, strict=True)))
    shared = [name for name in frame.columns if name in model_points.columns]
    points = model_points.assign(**{name: frame[name] for name in shared})
    is_kept = faults.is_sound[asked.codes]
    return CorrectedModelPoints(points[is_kept], faults.table(asked.names), error)


def _orientation_error(orientation, xyz, model):
    sort = segments(model, len(orientation.models))
    xyz, model = xyz[sort.order], model[sort.order]
    adjustment = orientation.adjustment
    base = orientation.models["base"].to_numpy(dtype=float)[model]
    elements = adjustment.elements[model]
    derivatives = correction_derivatives(xyz, base, elements, orientation.case)[:, :2]
    variance = deformation_variance(
        derivatives, adjustment.cofactor, xyz[:, :2], sort.start
    )
    return np.sqrt(variance) * adjustment.sigma_0


def _find_models(orientation, names, has_coverages, faults):
    """Find the orientation of each model; a fault where there is none."""
    known, wanted = orientation.models, models_frame(names)
    if not (has_coverages and orientation.has_coverages):
        wanted = wanted.drop(columns="coverage")
    place, is_ambiguous = places_of_models(wanted, known)
    is_ambiguous = is_ambiguous | wanted.duplicated(keep=False).to_numpy()
    faults.say(is_ambiguous, "several coverages have this model", NAME_COVERAGE)
    faults.say(place < 0, "it has no y-parallaxes", "Measure y-parallaxes in it")
    remedies = np.full(len(known), "", dtype=object)
    is_usable = known["is_usable"].to_numpy()
    remedies[~is_usable] = orientation.failures["remedy"]
    reasons = known["reason"].to_numpy()
    faults.say(~is_usable[place], reasons[place], remedies[place])
    return place


@dataclass(frozen=True, eq=False)
class ModelFaults:
    """Why models stay out; of several reasons the first one counts."""

    # reasons, remedies: (n_models,): empty text where nothing is wrong
    reasons: np.ndarray
    remedies: np.ndarray

    @classmethod
    def none(cls, n_models):
        """Begin with models that have no faults."""
        return cls(*(np.full(n_models, "", dtype=object) for _ in range(2)))

    @property
    def is_sound(self):
        """Whether nothing is wrong, ndarray of bool, shape (n_models,)."""
        return self.reasons == ""

    def say(self, is_bad, reason, remedy):
        """Say what is wrong with some models.

        ``is_bad`` (n_models,): reason and remedy are one text, or one for each model.
        """
        is_new = is_bad & self.is_sound
        for texts, text in ((self.reasons, reason), (self.remedies, remedy)):
            texts[is_new] = text if isinstance(text, str) else text[is_new]

    def say_of_rows(self, codes, reason, remedy):
        """Say what is wrong with the models of some rows.

        ``codes`` are the models of the bad rows.
        """
        is_bad = np.zeros(len(self.reasons), dtype=bool)
        is_bad[codes] = True
        self.say(is_bad, reason, remedy)

    def table(self, names) -> pd.DataFrame:
        """Return the failures as a table.

        ``names`` are pairs of coverage and model_id.
        """
        failed = np.flatnonzero(~self.is_sound)
        return failures_table(
            (*names[k], STAGE, self.reasons[k], self.remedies[k]) for k in failed
        )


def models_frame(names) -> pd.DataFrame:
    """Pairs of coverage and model_id as a table."""
    return pd.DataFrame(list(names), columns=["coverage", "model_id"], dtype=object)


def places_of_models(wanted, known):
    """Find models of one table in another, by all columns of the first.

    Gives the row in ``known``, −1 where there is none, and whether there are several.
    """
    keys = list(wanted.columns)
    have, want = pd.MultiIndex.from_frame(known[keys]), pd.MultiIndex.from_frame(wanted)
    is_first = ~have.duplicated()
    found = have[is_first].get_indexer(want)
    rows = np.append(np.flatnonzero(is_first), -1)
    return rows[found], want.isin(have[have.duplicated()])


def _table_of_models(orientation):
    """Table of the first models: redundancy, sigma_0, elements [gon, model unit]."""
    names = ELEMENTS[orientation.case]
    is_shift = np.array([name in SHIFTS for name in names])
    values = orientation.adjustment.elements / np.where(is_shift, 1.0, RADIANS_PER_GON)
    models = orientation.models.head(MOST_PRINTED)
    ids = all_shortened(models["model_id"], WIDEST_NAME)
    rows = [
        [
            name,
            str(row.n_points),
            typesetting.number(row.sigma_0),
            *(typesetting.fixed(value, 4) for value in elements),
        ]
        for row, name, elements in zip(models.itertuples(), ids, values, strict=False)
    ]
    header = [translated("model"), translated("points"), "sigma_0", *names]
    text = typesetting.table(rows, header=header)
    rest = len(orientation.models) - MOST_PRINTED
    title = mark("Corrections still to be made [gon]")
    if is_shift.any():
        title = mark(
            "Corrections still to be made [gon; d_by, d_bz in the unit of the model]"
        )
    lines = [translated(title), text]
    return "\n".join([*lines, translated(AND_MORE, n=rest)] if rest > 0 else lines)
