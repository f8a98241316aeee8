"""Is the claim supported? What was measured, against what the claimed figures predict.

The propagated figure, or the budget where nothing can be propagated, rests on a model
of errors: sizes that were given, and what is independent of what. Each test compares a
quantity of the block with draws from that model: how far coverages differ, how large
residuals are, whether those of neighbours are alike, what known points are missed by.

See docs/theory/claim.md.
"""

from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import compress

import numpy as np
from scipy.special import chdtrc  # scipy.stats takes a second to import

from einschalt.foundations.frame_columns import values_of
from einschalt.foundations.language import mark, mark_each
from einschalt.foundations.names import encode, is_among
from einschalt.pipeline.assessment.evidence.fits.mean_residuals import (
    fits_without,
    mean_residuals,
)
from einschalt.pipeline.assessment.evidence.without_gross_errors import (
    MOST_SUSPECTS,
    good_rows,
)
from einschalt.stages.coverage_screening import DIFFERENCES, coverage_differences
from einschalt.stages.error_propagation.error_model import PLAN, ErrorModel
from einschalt.stages.error_propagation.given_points import (
    LEAST_APART,
    errors_of_control,
)
from einschalt.theory.adjustment.detectable_shift import DetectableShift
from einschalt.theory.adjustment.monte_carlo import (
    NUMBERS_AT_ONCE,
    apply_chains,
    draw_errors,
    tail_of_mean,
    tail_of_squares,
)
from einschalt.theory.adjustment.multiple_testing import is_rejected_by_holm
from einschalt.theory.adjustment.point_operator import selection
from einschalt.theory.adjustment.significance import CLAIM_SIGNIFICANCE
from einschalt.theory.adjustment.spatial_correlation import (
    Correlogram,
    correlogram,
    morans_i,
    nearest_neighbours,
)

MOST_DRAWS, FEWEST_DRAWS = 100, 12
# fewer points tell nothing of their neighbours
FEWEST_POINTS = 10
NO_RESIDUAL = 1e-9  # metres: of models without redundancy


@dataclass(frozen=True)
class ClaimTest:
    """One quantity of a block against what the claim predicts."""

    name: str
    n_points: int
    # TOTAL root mean square [m]; of the correlation, Moran's I
    observed: float
    predicted: float
    p_value: float  # probability of a quantity as large as this where the claim holds
    is_length: bool = True


@dataclass(frozen=True, eq=False)
class Claim:
    """The tests of a block's claim."""

    tests: tuple[ClaimTest, ...]  # empty where no model of errors can be made
    # residuals of the low flight, and their draws
    residuals: "ResidualField | None" = field(metadata={"is_plain": False})
    # what is only assumed: that errors of given approximate coordinates are
    # independent, or that orientations are without errors
    assumption: str = ""
    # why regions of given points were not looked for, a code; empty where they were
    untested_regions: str = ""
    # where none is displaced: how far they may be all the same
    detectable_shift: DetectableShift | None = None
    # coverage differences against the budget, which takes all values of a point for
    # independent. It is no claim where there is a propagated figure.
    paper: ClaimTest | None = None

    @property
    def is_assumed(self) -> bool:
        """Whether the prediction rests on an assumption."""
        return bool(self.assumption)

    @cached_property
    def rejected(self) -> tuple[ClaimTest, ...]:
        """Tests that the block does not pass, by Holm over all of them."""
        return _beyond_chance(self.tests, [test.p_value for test in self.tests])

    @cached_property
    def too_small(self) -> tuple[ClaimTest, ...]:
        """Tests whose quantity is smaller than chance explains, by Holm over all.

        The claim does not fall by it; what was measured may not be independent.
        """
        lengths = [test for test in self.tests if test.name in OF_INDEPENDENCE]
        return _beyond_chance(lengths, [1.0 - test.p_value for test in lengths])

    @property
    def is_supported(self) -> bool:
        """Whether no test contradicts the claim."""
        return not self.rejected

    @property
    def enlargement(self) -> float:
        """By how much the measurements exceed the claim at least; 1 where it stands."""
        # control that is worse than given shows more in its own differences than in
        # the points: they give no bound
        ratios = [
            test.observed / test.predicted
            for test in self.rejected
            if test.is_length and test.name != LEFT_OUT
        ]
        return float(max([1.0, *ratios]))

    def of(self, name: str) -> ClaimTest | None:
        """The test of that name, or None."""
        return next((test for test in self.tests if test.name == name), None)


def _beyond_chance(tests, p_values):
    """Those of some tests that chance does not explain, by Holm over all of them."""
    if not np.isfinite(p_values).any():
        return ()
    is_rejected = is_rejected_by_holm(p_values, CLAIM_SIGNIFICANCE)
    return tuple(compress(tests, is_rejected))


@dataclass(frozen=True, eq=False)
class ResidualField:
    """Residuals of the low flight at their points, and draws of them."""

    # shape (n_points, 2) [m]
    positions: np.ndarray
    vectors: np.ndarray
    drawn: np.ndarray  # shape (n_points, 2, n_draws) [m]

    @cached_property
    def correlogram(self) -> Correlogram:
        """Correlation by distance."""
        return correlogram(self.vectors, self.positions)

    @cached_property
    def expected(self) -> Correlogram:
        """The same of the draws: its correlations have a column for each."""
        return correlogram(self.drawn, self.positions)


UNTESTED = Claim((), None)
COVERAGES = mark("coverage differences")
COVERAGES_HIGH = mark("coverage differences, high flight")
RESIDUALS = mark("residuals of the low flight")
NEIGHBOURS = mark("correlation of neighbouring residuals")
REGIONS = mark("shift of a region / standard error")
LEFT_OUT = mark("control points, each left out")
KNOWN = mark_each({"check": "check points", "control": "control points"})
# differences of what was measured apart: tested for being too small as well
OF_INDEPENDENCE = (COVERAGES, COVERAGES_HIGH)


def examine_claim(examined) -> Claim:
    """Test what was measured against what the claimed figures predict."""
    model = examined.error_model
    if model is None or not examined.low.fit.redundancy.any():
        return UNTESTED
    rows = max(model.low.measured.shape[0], 1)
    n_draws = int(np.clip(NUMBERS_AT_ONCE // rows, FEWEST_DRAWS, MOST_DRAWS))
    return _ClaimTests(examined, model, n_draws).claim()


class _ClaimTests:
    """A block and draws from its model of errors."""

    def __init__(self, examined, model: ErrorModel, n_draws):
        self.examined, self.model = examined, model
        self.drawn = model.draw(n_draws, seed=0)

    def claim(self):
        """Make all tests."""
        of_residuals, field = self._residuals()
        tests = (
            self._coverages(COVERAGES, self.differences, self.drawn.low),
            self._high_coverages(),
            *of_residuals,
            self._regions(),
            self._left_out_control(),
            *(self._known_points(role) for role in self._roles()),
        )
        return Claim(
            tuple(test for test in tests if test is not None),
            field,
            self._assumption(),
            untested_regions=self.examined.region_scan.untested,
            detectable_shift=self.examined.region_scan.detectable,
            paper=self._against_paper(),
        )

    @cached_property
    def differences(self):
        """Differences of the coverages of the low flight."""
        return coverage_differences(self.examined.means).needed()

    def _assumption(self):
        if not self.model.is_assumed:
            return ""
        is_given = self.examined.high is None
        return "independent_approximations" if is_given else "perfect_orientations"

    def _against_paper(self):
        differences = self.differences.table
        good = self._without_suspects(differences["point_id"])
        d = values_of(differences, DIFFERENCES)[good]
        error = differences["standard_error_paper"].to_numpy()[good]
        if not len(d) or not np.isfinite(error).all():
            return None
        ratio = np.sum(d**2) / np.sum(error**2)
        return ClaimTest(
            COVERAGES,
            len(d),
            float(np.sqrt(np.mean(np.sum(d**2, axis=1)))),
            float(np.sqrt(np.mean(error**2))),
            float(chdtrc(2 * len(d), 2 * len(d) * ratio)),
        )

    def _high_coverages(self):
        if self.drawn.high is None:
            return None
        differences = coverage_differences(self.examined.high.means).needed()
        return self._coverages(COVERAGES_HIGH, differences, self.drawn.high)

    def _coverages(self, name, differences, drawn):
        table = differences.table
        if len(table) == 0:
            return None
        axes = self.model.axes
        operator = differences.operator(axes.count(len(drawn)), axes)
        good = self._without_suspects(table["point_id"])
        of_draws = axes.plan(operator.apply(drawn))[good]
        return _test_of_size(name, values_of(table, DIFFERENCES)[good], of_draws)

    def _without_suspects(self, point_ids):
        points = self.examined.points
        suspects = points.loc[points["is_suspect"], "point_id"]
        return good_rows(point_ids.isin(suspects).to_numpy())

    def _residuals(self):
        """Size of the residuals, and likeness of neighbours; with their field."""
        model = self.model
        low = self.examined.low
        is_suspect = low.residuals["is_suspect"].to_numpy(dtype=bool)
        # of very many suspects it is not these that are wrong
        is_out = is_suspect & (is_suspect.sum() <= MOST_SUSPECTS * len(is_suspect))
        means = mean_residuals(low, model, fits_without(low, low.residuals[is_out]))
        if not len(means.vectors):
            return (), None
        drawn = means.of_values.apply(self.drawn.low)
        of_draws = model.axes.plan(drawn - means.of_ground.apply(self.drawn.ground))
        vectors = means.vectors[:, : len(PLAN)]
        size = _test_of_size(RESIDUALS, vectors, of_draws)
        if model.is_assumed and self.examined.block.approximate_m_0_m is not None:
            # errors that neighbours share leave small residuals: both tails
            p_value = 2.0 * min(size.p_value, 1.0 - size.p_value)
            size = replace(size, p_value=p_value)
        if len(means.vectors) < FEWEST_POINTS:  # of which neighbours say nothing
            return (size,) if size.predicted > NO_RESIDUAL else (), None
        near = nearest_neighbours(means.positions)
        i, drawn_i = morans_i(vectors, near), morans_i(of_draws, near)
        autocorrelation = ClaimTest(
            NEIGHBOURS,
            len(means.vectors),
            float(i),
            float(np.mean(drawn_i)),
            tail_of_mean(i, drawn_i),
            is_length=False,
        )
        field = ResidualField(means.positions, vectors, of_draws)
        return (size, autocorrelation), field

    def _regions(self):
        """The clearest shift of a region of given approximate points."""
        scan = self.examined.region_scan
        if not scan.n_tried:
            return None
        # χ² of two degrees of freedom that one of so many exceeds on the average
        expected = float(np.sqrt(2.0 * np.log(scan.n_tried)))
        sizes = scan.clearest, expected, scan.p_value
        return ClaimTest(REGIONS, scan.n_points, *sizes, is_length=False)

    def _left_out_control(self):
        """Control points of the high flight predicted from all the others."""
        left_out = self.examined.left_out_control
        if left_out is None:
            return None
        drawn = apply_chains(self.drawn.sources, left_out.chains)
        of_draws = self.model.axes.plan(drawn)
        good = good_rows(self.examined.control_left_out["is_suspect"].to_numpy())
        return _test_of_size(LEFT_OUT, left_out.differences[good], of_draws[good])

    def _roles(self):
        """Roles of known points that took no part in the result."""
        return ("check",) if self.examined.control_takes_part else KNOWN

    def _known_points(self, role):
        """Densified minus given coordinates, which have errors of their own."""
        examined, model = self.examined, self.model
        given = examined.block.control_points
        if given is None or "standard_error_m" not in given:
            return None
        # shifts of groups whose size nothing tells are drawn as 0
        unknown = self._control().to_be_estimated
        if unknown and not np.any(self.model.standard_errors.get(unknown, 0.0)):
            return None
        observed, roles = missed_in_plan(examined)
        is_known = (roles == role) & np.isfinite(observed).all(axis=1)
        lone = [each.point_id for each in examined.lone_points]
        is_known &= ~is_among(examined.means.points["point_id"], lone)
        rows = np.flatnonzero(is_known)
        picked = (selection(rows, len(observed), model.axes) @ model.final).formed()
        of_points = model.axes.plan(picked.apply(self.drawn.low))
        names = examined.means.points["point_id"].to_numpy(dtype=object)[rows]
        of_given = self._given_errors(names)
        return _test_of_size(KNOWN[role], observed[rows], of_points - of_given)

    def _control(self):
        return errors_of_control(self.examined.block, self.model.axes)

    def _given_errors(self, point_ids):
        """Draws of the errors of given coordinates."""
        given = self.examined.block.control_points
        place = encode(given["point_id"]).locate(encode(point_ids))
        axes = self.model.axes
        if self.drawn.control is not None:
            return axes.plan(self.drawn.control)[place]
        control = self._control()
        known = self.drawn.sources
        if not control.sizes.keys() <= known.keys():
            n_draws = self.drawn.low.shape[1]
            known = draw_errors(control.sizes, axes, n_draws=n_draws, seed=1)
        return axes.plan(control.apply(known))[place]


def missed_in_plan(examined):
    """Densified minus given coordinates, before residuals were distributed; roles.

    (n_points, 2) [m], NaN where none are given, and (n_points,), of all points of the
    means in their order. A control point whose given coordinates are its approximate
    ones is none: it took part. A check point with such coordinates did not, as nothing
    is fitted onto it.
    """
    plan = list(PLAN)
    points = examined.means.points
    given = examined.block.control_points.set_index("point_id")
    given = given.reindex(points["point_id"])
    differences = values_of(points, plan) - values_of(given, plan)
    role = given["role"].to_numpy(dtype=object)
    if examined.high is None:
        approximate = examined.block.approximate_points.set_index("point_id")[plan]
        apart = approximate.reindex(points["point_id"]).to_numpy() - given[plan]
        is_same = np.hypot(*apart.to_numpy(dtype=float).T) < LEAST_APART
        role[is_same & (role == "control")] = "approximate"
    return differences, role


def _test_of_size(name, observed, of_draws):
    squares = np.sum(observed**2)
    drawn = np.sum(of_draws**2, axis=(0, 1))
    n_points = len(observed)
    if not n_points:
        return None
    return ClaimTest(
        name,
        n_points,
        float(np.sqrt(squares / n_points)),
        float(np.sqrt(np.mean(drawn) / n_points)),
        tail_of_squares(squares, drawn),
    )
