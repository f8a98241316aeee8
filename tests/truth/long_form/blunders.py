"""One blunder drawn at random in a clean block: is it called out, and covered?

Kind, size, place and seed are drawn; plane and spatial blocks, both ways of
densification. Beside them blocks without a blunder, in which nothing may be found but
what chance makes.
"""

from collections import Counter
from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import binom
from tests.truth.long_form.blunder_kinds import KINDS, kinds_for
from tests.truth.long_form.blunder_power import is_too_weak
from tests.truth.long_form.figures import Figure, Table, of_blocks

from einschalt.foundations.errors import EinschaltError
from einschalt.pipeline.assessment.finding import Gravity
from einschalt.pipeline.densify import densify
from einschalt.pipeline.simulation.simulate_block import PRESETS, simulate_block
from einschalt.theory.adjustment.significance import (
    CLAIM_SIGNIFICANCE,
    FINDING_SIGNIFICANCE,
    SYSTEMATIC_SIGNIFICANCE,
)

N_BLUNDERS, N_CLEAN = 300, 60
FIRST_BLUNDER, FIRST_CLEAN = 1000, 50_000
METHODS = ("two_step", "simultaneous")
GEOMETRIES = {
    "affine": {},
    "helmert": {"transformation": "helmert"},
    "spatial": {"transformation": "helmert_3d"},
    "images": {"measurement": "images"},
}
PLAN = ["easting", "northing"]
# of the claimed error, RMS of the new points: what a blunder must move them by
MOVED = 2.0
LEAST_CALLED_OUT, LEAST_COVERED = 98.0, 0.5
# of grave findings in a block without a blunder, by what they test; others 0.001
LEVELS = {
    "claim_that_does_not_stand": CLAIM_SIGNIFICANCE,
    "adjustment_that_misfits": CLAIM_SIGNIFICANCE,
    "heights_beyond_claim": CLAIM_SIGNIFICANCE,
    "broken_network": SYSTEMATIC_SIGNIFICANCE,
    "strained_network": SYSTEMATIC_SIGNIFICANCE,
    "broken_heights": SYSTEMATIC_SIGNIFICANCE,
    "wrong_control_height": SYSTEMATIC_SIGNIFICANCE,
    "heights_out_of_scale": SYSTEMATIC_SIGNIFICANCE,
}
CHANCE = 0.001


@dataclass(frozen=True)
class Outcome:
    """What became of a block in one way of densification."""

    kind: str
    is_refused: bool = False
    # true, claimed and believed error of the new points, RMS: in plan [, in height] [m]
    errors: tuple = ()
    is_supported: bool | None = None
    # codes of the findings that have no other cause, by their gravity
    warnings: tuple = ()
    grave: tuple = ()
    # a blunder in control that not even the best test would find
    is_too_weak: bool = False

    @property
    def moved(self):
        """Those errors that are more than twice what was claimed."""
        return [
            (true, claimed, believed)
            for true, claimed, believed in self.errors
            if not true <= MOVED * claimed
        ]

    @property
    def falls(self):
        """Whether the claim is not believed."""
        return self.is_refused or self.is_supported is not True

    @property
    def is_called_out(self):
        """Whether the claim falls, or a warning names something."""
        return self.falls or bool(self.grave) or bool(self.warnings)

    @property
    def covered(self):
        """The figure to believe by the true error, the smallest."""
        return min((believed / true for true, _, believed in self.moved), default=1.0)

    @property
    def is_missed(self):
        """Whether it moves points, and is not told or not covered."""
        is_told = self.is_called_out and self.covered >= LEAST_COVERED
        return bool(self.moved) and not is_told


def tables():
    """Run the study.

    Returns
    -------
    list of Table
    """
    found = [o for both in of_blocks(study, _seeds(FIRST_BLUNDER)) for o in both]
    clean = of_blocks(study_clean, range(FIRST_CLEAN, FIRST_CLEAN + N_CLEAN))
    hidden = {kind.name for kind in KINDS if not kind.can_show}
    shown = [outcome for outcome in found if outcome.kind not in hidden]
    return [
        Table(
            f"One blunder each: {N_BLUNDERS} drawn at random, both methods",
            "Blocks of the preset demo (affine, helmert, spatial machine coordinates, "
            "images) with blunders whose kind, size (0.1 to 1000 m on the ground) and "
            "place were drawn. `Moved` are blocks whose new points, in plan or in "
            "height, are wrong by more than twice the claim (RMS). `Too weak` are "
            "misses that not even a test that knows the blunder except for its size "
            "would find (α = 0.001, power 0.80). Of the others at least "
            f"{LEAST_CALLED_OUT:g} % must be detected, by rejected input, a rejected "
            "claim or a finding, and the figure to believe must not be below half of "
            "the true error in any of them. Kinds that show in no test follow below.",
            (
                *("blunder", "blocks", "input rejected", "too weak", "moved"),
                *("claim rejected", "detected [%]", "least figure/true"),
            ),
            [
                *(_row(kind.name, shown) for kind in KINDS if kind.can_show),
                _row("all", shown, is_judged=True),
            ],
        ),
        Table(
            "Blunders that no data can show",
            "Common movements of everything, which no difference and no residual "
            "shows. The table gives the number of blocks, and of those whose points "
            "are moved by more than twice the claim.",
            ("blunder", "blocks", "moved"),
            [_hidden_row(name, found) for name in sorted(hidden)],
        ),
        Table(
            f"False alarms of grave findings, {N_CLEAN} blocks without a blunder",
            "Findings that lead to rejection of a claim, in blocks of all four kinds "
            "with both methods; at most as many as chance allows at the level of the "
            f"test with the probability {CHANCE:g}.",
            ("finding", "level", "alarms"),
            _alarms(clean),
        ),
    ]


def _seeds(first):
    return range(first, first + N_BLUNDERS)


def _row(name, outcomes, *, is_judged=False):
    own = [o for o in outcomes if is_judged or o.kind == name]
    weak = [o for o in own if o.is_too_weak]
    moved = [o for o in own if o.moved and not o.is_too_weak]
    share = 100.0 * np.mean([o.is_called_out for o in moved]) if moved else np.nan
    covered = min((o.covered for o in moved), default=np.nan)
    low = LEAST_CALLED_OUT if is_judged else -np.inf
    return (
        name,
        f"{len(own)}",
        f"{sum(o.is_refused for o in own)}",
        f"{len(weak)}",
        f"{len(moved)}",
        f"{sum(o.falls for o in moved)}",
        Figure(share, low=low, form=".1f") if moved else "",
        Figure(covered, low=LEAST_COVERED, form=".2f") if moved else "",
    )


def _hidden_row(name, outcomes):
    own = [o for o in outcomes if o.kind == name]
    return name, f"{len(own)}", f"{sum(bool(o.moved) for o in own)}"


def _alarms(clean):
    rows = []
    for place, method in enumerate(METHODS):
        outcomes = [both[place] for both in clean]
        counts = Counter(code for o in outcomes for code in o.grave)
        for code in sorted({*LEVELS, *counts}):
            level = LEVELS.get(code, FINDING_SIGNIFICANCE)
            most = int(binom.isf(CHANCE, len(outcomes), level))
            n_alarms = Figure(counts[code], high=most, form="d")
            if counts[code]:
                rows.append((f"{code}, {method}", f"{level:g}", n_alarms))
        n_falls = sum(o.falls for o in outcomes)
        # of plan, heights, patterns in both: one in a hundred each
        most = int(binom.isf(CHANCE, len(outcomes), 4.0 * CLAIM_SIGNIFICANCE))
        rows.append(
            (f"claim falls, {method}", "0.04", Figure(n_falls, high=most, form="d"))
        )
    return rows


def study(seed):
    """What becomes of one blunder in both ways: list of Outcome."""
    block, kind, rng = draw(seed)
    try:
        spoilt = kind.spoil(block, rng)
    except EinschaltError:  # refused as it is read
        return [Outcome(kind.name, is_refused=True) for _ in METHODS]
    found = [outcome_of(kind.name, spoilt, block.truth, way) for way in METHODS]
    if kind.can_show and any(o.is_missed for o in found):
        weak = is_too_weak(block, spoilt)
        found = [replace(o, is_too_weak=weak and o.is_missed) for o in found]
    return found


def study_clean(seed):
    """What becomes of a block without a blunder in both ways: list of Outcome."""
    block = _clean_block(tuple(GEOMETRIES)[seed % len(GEOMETRIES)], seed)
    return [outcome_of("none", block, block.truth, way) for way in METHODS]


def draw(seed):
    """A clean block, a kind of blunder that it may have, and its random numbers."""
    rng = np.random.default_rng([2026, seed])
    geometry = tuple(GEOMETRIES)[rng.integers(len(GEOMETRIES))]
    block = _clean_block(geometry, 10_000 + seed)
    kinds = kinds_for(block)
    return block, kinds[rng.integers(len(kinds))], rng


def _clean_block(geometry, seed):
    demo = replace(PRESETS["demo"].geometry, **GEOMETRIES[geometry])
    return simulate_block("demo", seed=seed, geometry=demo)


def outcome_of(kind, block, truth, method):
    """Densify a block in one way, and hold what it says against the truth."""
    try:
        result = densify(block, block.settings.updated({"method": method}))
    except EinschaltError:
        return Outcome(kind, is_refused=True)
    judged = result.assessment
    alone = [found for found in judged.findings if not found.explained_by]
    return Outcome(
        kind,
        errors=_errors(result, truth),
        is_supported=judged.claim_is_supported,
        warnings=tuple(f.code for f in alone if f.gravity is Gravity.WARNING),
        grave=tuple(f.code for f in judged.findings if f.gravity is Gravity.GRAVE),
    )


def _errors(result, truth):
    figures, judged = result.figures, result.assessment
    new = result.points[result.points["role"] == "new"]
    truth = truth.set_index("point_id").loc[new["point_id"]]
    miss = np.hypot(*(new[axis].to_numpy() - truth[axis].to_numpy() for axis in PLAN))
    known = np.isfinite(figures.mean_total)
    claimed = figures.mean_total if known else figures.mean_paper
    found = [(_rms(miss), claimed, judged.credible.value)]
    if "height" in new and "height" in truth:
        lift = new["height"].to_numpy() - truth["height"].to_numpy()
        claimed = _rms(new.get("standard_error_height", np.nan))
        found.append((_rms(lift), claimed, judged.credible_heights.value))
    return tuple(found)


def _rms(values):
    return float(np.sqrt(np.nanmean(np.asarray(values, dtype=float) ** 2)))
