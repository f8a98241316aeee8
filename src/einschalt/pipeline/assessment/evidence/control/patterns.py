"""Control that is wrong together: a network broken in two, or bent.

Each control point is predicted without itself (see ``leave_one_out``). What a step
along a line, a low-order strain or one wrong point makes of these differences is known
from the operators of the propagation, and so is their full covariance: the pattern
that explains them best is tested among all of them (Bonferroni). Plan and heights are
tested apart. What moves, turns or stretches everything alike shows in no difference.

See docs/theory/claim.md.
"""

from dataclasses import dataclass, replace
from itertools import compress

import numpy as np
from scipy.linalg import solve_triangular

from einschalt.foundations.frame_columns import values_of
from einschalt.foundations.names import is_among
from einschalt.pipeline.assessment.evidence.control.signatures import (
    HEIGHT,
    PLAN,
    Differences,
    Kind,
    Pattern,
    Scores,
    Signatures,
)
from einschalt.pipeline.assessment.evidence.ground.given_region import is_large
from einschalt.pipeline.assessment.evidence.systematic_errors import SURELY_NOT_SCALED
from einschalt.theory.adjustment.displaced_group import find_displaced_group
from einschalt.theory.adjustment.pattern_shapes import (
    FEWEST_ON_A_SIDE,
    quadratic_strains,
    steps_along_lines,
)
from einschalt.theory.adjustment.pattern_tests import nested_p_value
from einschalt.theory.adjustment.significance import SYSTEMATIC_SIGNIFICANCE

# fewer points tell no pattern; of more the covariance would be too large
FEWEST_CONTROL, MOST_CONTROL = 6, 500
FEW_ON_A_SIDE = 3
BEYOND_ERRORS = 2.0  # times what errors make of a scale of heights
MOST_WRONG = 6  # points whose errors are estimated together


@dataclass(frozen=True, eq=False)
class FoundPattern:
    """The pattern that explains the differences best, where chance does not."""

    kind: Kind
    flights: tuple[str, ...]
    # the points that it displaces, or the smaller part of them
    point_ids: tuple[str, ...]
    n_control: int
    # of each axis: easting and northing, or height [m]; of a scale, a ratio
    amplitude: tuple[float, ...]
    p_value: float  # of all patterns together
    moved: float  # what it does to the new points, TOTAL in plan or height, RMS [m]
    # points that are wrong each by itself: that of the pattern, and others beside it
    wrong_ids: tuple[str, ...] = ()
    # whether errors that are all larger by one factor do not explain it as well
    is_told_apart: bool = True
    is_of_adjustment: bool = False  # found in the corrections of one adjustment

    @property
    def size(self):
        """Length of the amplitude."""
        return float(np.linalg.norm(self.amplitude))


@dataclass(frozen=True)
class ControlPatterns:
    """Patterns in the control of a block; None where chance explains everything."""

    plan: FoundPattern | None
    height: FoundPattern | None
    # what chance does not explain, be it a pattern or larger errors: what the clearest
    # pattern does to the new points, TOTAL in plan, and in height, RMS [m]
    moved_plan: float = 0.0
    moved_height: float = 0.0
    # probability of the clearest pattern among all, in plan and in height
    p_plan: float = 1.0
    p_height: float = 1.0
    n_control: int = 0  # points that patterns were looked for in
    # whether it is approximate points that control contradicts in plan
    is_beside_given: bool = False

    @property
    def unnamed_p_value(self):
        """Probability of what chance does not explain and no pattern names; NaN."""
        unnamed = [
            p_value
            for found, moved, p_value in (
                (self.plan, self.moved_plan, self.p_plan),
                (self.height, self.moved_height, self.p_height),
            )
            if found is None and moved > 0.0
        ]
        return min(unnamed, default=np.nan)


NO_PATTERNS = ControlPatterns(None, None)
NOTHING = (None, 0.0, 1.0)  # of either: pattern, what it moves, and its probability


def find_control_patterns(examined, set_aside=frozenset()) -> ControlPatterns:
    """Look for patterns in control points that are predicted without themselves.

    In plan in the corrections of an adjustment of everything, where it was made: they
    show smaller ones. Control that was ``set_aside``, names of points, may be as wrong
    as it likes, and is part of no pattern.
    """
    control, left_out = examined.block.control_points, examined.left_out_control
    if left_out is None:
        return _in_given_heights(examined)
    names = [name for name in left_out.point_ids if name not in set_aside]
    if len(names) < FEWEST_CONTROL or len(left_out.point_ids) > MOST_CONTROL:
        return NO_PATTERNS
    is_free = control["point_id"].isin(set_aside).to_numpy(dtype=bool)
    is_used = (control["role"] != "check").to_numpy() & ~is_free
    signatures = Signatures(examined, left_out)
    patterns = _patterns(control, names, is_used)
    scores, height = examined.patterns.scores, NOTHING
    shown = Differences(signatures, PLAN) if scores is None else Scores(scores)
    plan = _worst(signatures, PLAN, patterns, shown, is_free, is_used)
    if left_out.has_heights:
        found = [*patterns, *_scales(examined.block, len(control))]
        height = _worst_height(signatures, found, is_free, is_used)
    both = (each for pair in zip(plan, height, strict=True) for each in pair)
    return ControlPatterns(*both, n_control=int(is_used.sum()))


def _in_given_heights(examined):
    """Patterns in heights onto which models go, with no high flight between them.

    Of given points that are no control, and may share errors, a scale or one point,
    where it moves heights by more than the errors that are known; of many points none
    but a scale.
    """
    given = examined.given_heights
    if given is None or len(given.point_ids) < FEWEST_CONTROL:
        return NO_PATTERNS
    n_given = len(given.control)
    is_used = is_among(given.control["point_id"], given.point_ids)
    patterns = _scales(examined.block, n_given)
    if n_given <= MOST_CONTROL:
        alone = _patterns(given.control, given.point_ids, is_used)
        kinds = [each for each in Kind if given.are_control or each is Kind.POINT]
        alone = [each for each in alone if each.kind in kinds]
        patterns = [*compress(alone, given.are_told(alone)), *patterns]
    is_free = np.zeros(n_given, dtype=bool)
    height, moved, p_value = _worst_height(given, patterns, is_free, is_used)
    if not (given.are_control or moved > given.predicted):
        return NO_PATTERNS
    return ControlPatterns(
        None,
        height,
        moved_height=moved,
        p_height=p_value,
        n_control=int(is_used.sum()),
    )


def find_height_pattern(adjusted, shown):
    """The clearest pattern in the heights of control of one adjustment of everything.

    ``adjusted`` tells what heights of control do to the points, as Signatures do;
    ``shown`` are Scores of the heights. FoundPattern or None, what it does to the new
    points, and its probability. Where all heights may be worse than given by one factor
    a part that lies apart is told nonetheless, and that it is not told apart.
    """
    control, places = adjusted.control, shown.known.places
    if not FEWEST_CONTROL <= len(places) <= MOST_CONTROL:
        return NOTHING
    is_used = np.zeros(len(control), dtype=bool)
    is_used[places] = True
    patterns = _patterns(control, control["point_id"][is_used], is_used)
    is_free = np.zeros(len(control), dtype=bool)
    found = _worst_height(adjusted, patterns, is_free, is_used, shown)
    if found[0] is None:
        return found
    return replace(found[0], is_of_adjustment=True), *found[1:]


def find_plan_pattern(adjusted, is_used, is_free):
    """The clearest pattern in the places of control of one adjustment of everything.

    ``adjusted`` tells what these do to the points, and to what is seen of them, as
    Signatures do. Which control takes part, and which may be as wrong as it likes,
    (n_control,) each. As of :func:`find_height_pattern`.
    """
    if not FEWEST_CONTROL <= np.count_nonzero(is_used) <= MOST_CONTROL:
        return NOTHING
    control = adjusted.control
    patterns = _patterns(control, control["point_id"][is_used], is_used)
    shown = Differences(adjusted, PLAN)
    found = _worst(adjusted, PLAN, patterns, shown, is_free, is_used)
    if found[0] is None:
        return found
    return replace(found[0], is_of_adjustment=True), *found[1:]


def wrong_control(patterns: ControlPatterns):
    """Names of the control points that are wrong in plan, each by itself."""
    return () if patterns.plan is None else patterns.plan.wrong_ids


def _scales(block, n_control):
    """Heights of the models of one flight, or of all, out of scale."""
    flights = tuple(block.flights)
    each = (*((name,) for name in flights), *([flights] if len(flights) > 1 else []))
    return [Pattern(Kind.SCALE, np.zeros(n_control), names) for names in each]


def signatures_of_scale(two_step):
    """What is seen of heights of all models that are out of scale by one; (n,).

    As numbers of unit variance, none where nothing is known of it; and what that moves
    the heights of the new points by, RMS [m].
    """
    signatures, left_out = two_step.given_heights, two_step.left_out_control
    has_heights = left_out is not None and left_out.has_heights
    if has_heights and len(left_out.point_ids) <= MOST_CONTROL:
        signatures = Signatures(two_step, left_out)
    if signatures is None or two_step.control_patterns.height is not None:
        return np.zeros(0), 0.0
    pattern = _scales(two_step.block, len(signatures.control))[-1]
    shown = signatures.of([pattern], HEIGHT)[0, :, 0]
    try:
        root = np.linalg.cholesky(signatures.covariance(HEIGHT))
    except np.linalg.LinAlgError:  # points without errors of their own
        return np.zeros(0), 0.0
    shown = solve_triangular(root, shown, lower=True)
    return shown, signatures.moved(pattern, (1.0,), HEIGHT)


def _worst(
    signatures, axes, patterns, shown, is_free, is_used, *, tells_doubtful=False
):
    """The clearest of all patterns in some axes, if chance does not explain it.

    FoundPattern, or None where errors that are all larger than given are no pattern
    (``tells_doubtful``: unless control lies apart or is bent then); what it does to the
    new points, 0 where chance explains it; and its probability.
    """
    tests = shown.tests(patterns, is_free)
    if tests is not None:
        tests = _without(tests, _scales_of_errors(tests, patterns, signatures))
    tests, place = _together(tests, patterns, shown, is_free)
    if place is None:
        return NOTHING
    pattern, amplitude = patterns[place], tests.amplitudes[place]
    p_value, if_scaled = (
        _of_family(tests, values)[place]
        for values in (tests.p_values, tests.p_values_if_scaled)
    )
    moved = [
        signatures.moved(each, amplitude, axes) for each in _wrong(pattern, is_used)
    ]
    together = _likewise(patterns, place, shown, is_free)
    if len(together) > 1:
        amplitudes = shown.together(together, is_free)
        of_control = np.stack([each.of_control for each in together], axis=1)
        moved.append(signatures.moved_by(of_control @ amplitudes, axes))
    moved = float(np.nan_to_num(max(moved)))
    is_told_apart = bool(if_scaled <= SURELY_NOT_SCALED)
    is_doubtful_told = tells_doubtful and pattern.kind is not Kind.POINT
    if not (is_told_apart or is_doubtful_told):
        return None, moved, float(p_value)
    names = signatures.control["point_id"].to_numpy(dtype=object)
    found = FoundPattern(
        kind=pattern.kind,
        flights=pattern.flights,
        point_ids=tuple(names[pattern.of_control != 0.0]),
        n_control=int(is_used.sum()),
        amplitude=tuple(map(float, amplitude)),
        p_value=float(p_value),
        moved=moved,
        wrong_ids=tuple(names[_rows_of(together, range(len(together)))])
        if pattern.kind is Kind.POINT
        else (),
        is_told_apart=is_told_apart,
    )
    return found, moved, found.p_value


def _worst_height(signatures, patterns, is_free, is_used, shown=None):
    """The clearest pattern in heights; or a group of points, if it explains more.

    Of a group the smaller part is taken for the wrong one, as of groups in plan.
    ``shown`` are scores of an adjustment, if they are known.
    """
    given = Differences(signatures, HEIGHT) if shown is None else shown
    among = signatures, HEIGHT, patterns, given, is_free, is_used
    found, shown = _worst(*among, tells_doubtful=shown is not None), given
    group = _group(signatures, patterns, shown, is_free, found[0])
    if group is None:
        return found
    rows, shift, p_value = group
    moved = signatures.moved(Pattern(Kind.GROUP, rows), (shift,), HEIGHT)
    names = signatures.control["point_id"].to_numpy(dtype=object)
    found = FoundPattern(
        kind=Kind.GROUP,
        flights=(),
        point_ids=tuple(names[rows != 0.0]),
        n_control=int(is_used.sum()),
        amplitude=(shift,),
        p_value=p_value,
        moved=float(np.nan_to_num(moved)),
    )
    return found, found.moved, p_value


def _group(signatures, patterns, shown, is_free, found):
    """Points whose heights are off by the same, wherever they lie.

    Which they are, (n_control,), by how much [m], and the probability; None without
    them, and where a line parts them from the others.
    """
    kinds = {each.kind for each in patterns}
    if not {Kind.POINT, Kind.STEP} <= kinds:
        return None
    points = [each for each in patterns if each.kind is Kind.POINT]
    places = [int(np.flatnonzero(each.of_control)[0]) for each in points]
    is_step = found is not None and found.kind is Kind.STEP
    behind = set(found.point_ids) if is_step else set()
    names = signatures.control["point_id"].to_numpy(dtype=object)[places]
    region = np.flatnonzero([name in behind for name in names])
    xy = values_of(signatures.control, ["easting", "northing"])[places]
    try:
        known = shown.scores(points, is_free)
    except np.linalg.LinAlgError:  # points without errors of their own
        return None
    among = (*known, xy - xy.mean(axis=0))
    group = find_displaced_group(*among, SYSTEMATIC_SIGNIFICANCE, region)
    if group is None or behind == set(names[group.rows]):
        return None
    rows = np.zeros(len(is_free))
    rows[np.array(places)[group.rows]] = 1.0
    return rows, float(group.shift[0]), group.p_value


def _scales_of_errors(tests, patterns, signatures):
    """Which patterns are scales that errors of heights make alone, (n_patterns,)."""
    return [
        pattern.kind is Kind.SCALE
        and abs(amplitude[0])
        < BEYOND_ERRORS * signatures.scale_of_errors(pattern.flights)
        for pattern, amplitude in zip(patterns, tests.amplitudes, strict=True)
    ]


def _clearest(tests):
    """Place of the clearest pattern; None where chance explains it."""
    place = None if tests is None else tests.worst
    if place is None:
        return None
    is_chance = _of_family(tests, tests.p_values)[place] > SYSTEMATIC_SIGNIFICANCE
    return None if is_chance else place


def _together(tests, patterns, shown, is_free):
    """The tests without steps of a few points that do not move together.

    Also the clearest of the rest. Two points side by side, each wrong by itself, look
    like a step at first; many that are moved as a line does not part them do not.
    """
    place = _clearest(tests)
    while place is not None and patterns[place].kind is Kind.STEP:
        part = patterns[place].of_control != 0.0
        if np.count_nonzero(part) > FEW_ON_A_SIDE:
            break
        freed = shown.tests(patterns, is_free | part)
        alone = np.nan if freed is None else nested_p_value(tests, place, freed)
        if not alone < SYSTEMATIC_SIGNIFICANCE:
            break
        n_shared = np.array([_n_points(each, ~part) for each in patterns])
        is_step = np.array([each.kind is Kind.STEP for each in patterns])
        tests = _without(tests, is_step & (n_shared > 0))
        place = _clearest(tests)
    return tests, place


def _n_points(pattern, is_free):
    """How many points a pattern displaces that are not free."""
    return np.count_nonzero((pattern.of_control != 0.0) & ~is_free)


def _without(tests, is_left_out):
    """The tests, as if some patterns explained nothing; they count as tried."""
    return replace(tests, squares=tests.squares * ~np.asarray(is_left_out))


def _of_family(tests, p_values):
    """Probabilities that the clearest of all tests is as clear (Bonferroni)."""
    return np.minimum(p_values * np.isfinite(tests.squares).sum(), 1.0)


def _likewise(patterns, place, shown, is_free):
    """What is estimated together with the clearest pattern, itself among it.

    Points that are wrong beside a point: one after the other is set free, while the
    clearest pattern of the rest is a point. Three terms make a quadratic strain.
    """
    kind, wrong = patterns[place].kind, []
    if kind is Kind.BEND:
        return [pattern for pattern in patterns if pattern.kind is kind]
    while kind is Kind.POINT and patterns[place].kind is kind:
        wrong.append(place)
        if len(wrong) == MOST_WRONG:
            break
        is_also_free = is_free | _rows_of(patterns, wrong)
        tests = shown.tests(patterns, is_also_free)
        if tests is None:
            break
        # a step with one point that is not free is that point
        is_same = [
            each.kind is Kind.STEP and _n_points(each, is_also_free) < FEWEST_ON_A_SIDE
            for each in patterns
        ]
        place = _clearest(_without(tests, is_same))
        if place is None:
            break
    return [patterns[place] for place in wrong]


def _rows_of(patterns, places):
    """Which control points are those of patterns, (n_control,)."""
    rows = np.zeros(len(patterns[0].of_control), dtype=bool)
    for place in places:
        rows |= patterns[place].of_control != 0.0
    return rows


def _wrong(pattern, is_used):
    """What may be wrong where this is found: of two large parts nothing tells which."""
    if pattern.kind is not Kind.STEP:
        return (pattern,)
    others = np.where(is_used, 1.0 - pattern.of_control, 0.0)
    n_inside, n_elsewhere = map(np.count_nonzero, (pattern.of_control, others))
    if not is_large(n_inside, n_elsewhere):
        return (pattern,)
    return (pattern, replace(pattern, of_control=others))


def _patterns(control, left_out, is_used):
    """Single points, steps along lines, and quadratic strains, of given control."""
    places = np.flatnonzero(is_used)
    offset = values_of(control, ["easting", "northing"])[places]
    offset = offset - offset.mean(axis=0)
    is_left_out = control["point_id"].isin(left_out).to_numpy()
    parts = [(Kind.POINT, np.eye(len(control))[is_left_out & is_used])]
    for kind, rows in (
        (Kind.STEP, steps_along_lines(offset)),
        (Kind.BEND, quadratic_strains(offset)),
    ):
        whole = np.zeros((len(rows), len(control)))
        whole[:, places] = rows
        parts.append((kind, whole))
    return [Pattern(kind, row) for kind, rows in parts for row in rows]
