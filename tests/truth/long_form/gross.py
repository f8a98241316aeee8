"""Are gross errors found, and what do those do that are not?

One per cent of the measurements of either flight are wrong by 50 µm. The final points
against those of the same blocks without gross errors, and every gross error that was
missed against its minimal detectable bias.
"""

from functools import cache, partial

import numpy as np
import pandas as pd
from scipy.stats import chi2, ncx2, poisson
from tests.truth.long_form.figures import Figure, Table, of_blocks, root_of_ratio

from einschalt.foundations.units import METRES_PER_UM
from einschalt.pipeline.adjust_block import adjust_block
from einschalt.pipeline.densify import densify
from einschalt.pipeline.settings import Settings
from einschalt.pipeline.simulation.noise import BlockNoise
from einschalt.pipeline.simulation.simulate_block import simulate_block
from einschalt.theory.adjustment.reliability import noncentrality

N_BLOCKS = 25
SHARE, SIZE_UM = 0.01, 50.0
FLIGHTS = ("high", "low")
WAYS = ("keep", "snoop", "huber", "tukey")
MODES = ("all", "most_central")
KEY = ["flight", "coverage", "model_id", "point_id"]
LOSS = {"high": 1.05}
COUNTS = (
    *("gross", "pairs", "shared", "weak"),
    *("found", "missed", "expected", "false"),
)
CHANCE = 0.001


def tables():
    """Run the study.

    Returns
    -------
    list of Table
    """
    blocks = {
        flight: of_blocks(partial(study, flight), range(N_BLOCKS)) for flight in FLIGHTS
    }
    size = f"{N_BLOCKS} blocks of the preset neukirchen, {SIZE_UM:g} µm"
    return [
        Table(
            f"Gross errors in one per cent of a flight's measurements, {size}",
            "Root mean square of the errors of the final points divided by that of the "
            "same blocks without gross errors: for all points, and for those whose "
            "gross errors could be found (at most 1.05); the next table counts the "
            "others. Models without redundancy cannot check their points.",
            ("flight", "mode", "outliers", "all points", "points with redundancy"),
            [row for flight in FLIGHTS for row in _ratio_rows(flight, blocks[flight])],
        ),
        Table(
            "Gross errors that were found and missed",
            "A gross error can be found if its point has three measurements in "
            "the flight or given coordinates (of two, either may be wrong), the others "
            "are good, and it is above its minimal detectable bias (α = 0.001, power "
            "0.80). Of these no more may be missed than the power of the test allows "
            "(with the probability 0.001). `Good ones` are good measurements that "
            "were rejected.",
            (
                *("flight", "gross errors", "of two", "beside others", "below bias"),
                *("the rest: found", "missed", "expected", "good ones"),
            ),
            [(f"{flight} flight", *_count_row(blocks[flight])) for flight in FLIGHTS],
        ),
    ]


def study(flight, seed, modes=MODES, ways=WAYS):
    """Compare one block with the same without gross errors.

    Parameters
    ----------
    flight : {"high", "low"}
    seed : int
    modes, ways : sequence of str
        Settings ``coverage_mean`` and ``outliers``, snoop among them.

    Returns
    -------
    dict
        Numbers of gross errors (``COUNTS``), and by mode and treatment the sums of
        squared errors: of all points and of those that have the redundancy, with gross
        errors and without.
    """
    noise = BlockNoise(
        **{
            f"{flight}_gross_error_share": SHARE,
            f"{flight}_gross_error_um": SIZE_UM,
        }
    )
    spoilt = simulate_block("neukirchen", seed=seed, noise=noise)
    gross = gross_errors_of(spoilt, flight)
    hopeless = gross.loc[~_can_be_found(gross), "point_id"]
    found = {}
    for mode in modes:
        for way in ways:
            settings = Settings(coverage_mean=mode, outliers=way)
            result = densify(spoilt, settings)
            squares = squared_errors(result, spoilt.truth)
            without = _squares_without(seed, settings)
            bare = _points_of_bare_models(result)
            has_redundancy = ~squares.index.isin(np.union1d(hopeless, bare))
            found[mode, way] = [
                [squares.sum(), without.sum()],
                [squares[has_redundancy].sum(), without[has_redundancy].sum()],
            ]
            if (mode, way) == (modes[0], "snoop"):
                found |= dict(zip(COUNTS, _counts(gross, result), strict=True))
    return found


@cache
def _squares_without(seed, settings):
    clean = simulate_block("neukirchen", seed=seed)
    return squared_errors(densify(clean, settings), clean.truth)


def squared_errors(result, truth):
    """Squared total error of each final point [m²], a Series by point_id."""
    columns = ["easting", "northing"]
    points = result.solution.points.set_index("point_id")[columns]
    return ((points - truth.set_index("point_id")[columns]) ** 2).sum(axis=1)


def gross_errors_of(block, flight):
    """The gross errors of a block, and whether they can be found.

    Parameters
    ----------
    block : SimulatedBlock
    flight : {"high", "low"}

    Returns
    -------
    DataFrame
        The key of each; is_pair (one of the only two measurements of its point),
        is_shared (another one at the same point), is_weak (not above the minimal
        detectable bias), p_missed (1 − power of the test).
    """
    # redundancy numbers follow from the geometry alone
    residuals = adjust_block(block, flights=flight).residuals
    n_tested = residuals.groupby(KEY[:3])["point_id"].transform("size")
    limit = chi2.isf(Settings().significance / n_tested, 2)
    size = SIZE_UM * METRES_PER_UM * block.flights[f"{flight}_flight"].scale_number
    excess = size / residuals["minimal_detectable_bias"] * noncentrality()
    power = residuals[KEY].assign(
        is_pair=_is_pair(residuals["point_id"], block.control_points),
        is_weak=residuals["minimal_detectable_bias"] >= size,
        p_missed=ncx2.cdf(limit, 2, excess**2),
    )
    gross = block.gross_errors[KEY].merge(power, on=KEY)
    return gross.assign(is_shared=gross["point_id"].duplicated(keep=False))


def _is_pair(point_id, control_points):
    given = control_points.loc[control_points["role"] != "check", "point_id"]
    return (point_id.groupby(point_id).transform("size") < 3) & ~point_id.isin(given)


def _can_be_found(gross):
    return ~(gross["is_pair"] | gross["is_shared"] | gross["is_weak"]).to_numpy()


def _points_of_bare_models(result):
    """Points of models that were left without redundancy: their errors are unchecked.

    Two of five control points that are wrong are found by the neighbours, and what is
    left of the model determines it, no more.
    """
    models = result.models
    is_bare = models["is_usable"] & (models["redundancy"] == 0)
    bare = pd.MultiIndex.from_frame(models.loc[is_bare, KEY[:3]])
    tables = [t.assign(flight=name) for name, t in result.solution.model_points.items()]
    measured = pd.concat(tables)[KEY]
    is_held = pd.MultiIndex.from_frame(measured[KEY[:3]]).isin(bare)
    return measured.loc[is_held, "point_id"].unique()


def _counts(gross, result):
    """Numbers of one block, in the order of COUNTS."""
    named = pd.MultiIndex.from_frame(result.gross_measurements[KEY])
    suspects = result.residuals[result.residuals["is_suspect"]]
    named = named.union(pd.MultiIndex.from_frame(suspects[KEY]))
    key = pd.MultiIndex.from_frame(gross[KEY])
    is_found, can = key.isin(named), _can_be_found(gross)
    is_shared = (gross["is_shared"] & ~gross["is_pair"]).to_numpy()
    return (
        len(gross),
        np.count_nonzero(gross["is_pair"]),
        np.count_nonzero(is_shared),
        np.count_nonzero(gross["is_weak"] & ~gross["is_pair"] & ~is_shared),
        np.count_nonzero(can & is_found),
        np.count_nonzero(can & ~is_found),
        gross.loc[can, "p_missed"].sum(),
        np.count_nonzero(~named.isin(key)),
    )


def _ratio_rows(flight, blocks):
    for mode in MODES:
        for way in WAYS:
            sums = np.array([block[mode, way] for block in blocks])
            everything, checked = np.moveaxis(sums, 1, 0)
            bounds = {} if way == "keep" else LOSS
            yield (
                f"{flight} flight",
                mode,
                way,
                root_of_ratio(*everything.T),
                root_of_ratio(*checked.T, **bounds),
            )


def _count_row(blocks):
    sums = {name: sum(block[name] for block in blocks) for name in COUNTS}
    most = float(poisson.isf(CHANCE, sums["expected"]))
    for name, number in sums.items():
        high = most if name == "missed" else np.inf
        yield Figure(number, high=high, form=".1f" if name == "expected" else "d")
