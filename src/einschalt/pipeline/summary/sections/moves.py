"""How far points were moved: by iterations, and by the distribution of residuals."""

import math

from einschalt.foundations.display_names import printable
from einschalt.foundations.typesetting import count, length, lengths
from einschalt.pipeline.summary.section import NO_SECTION, Section

MOST_SHOWN = 8
CUT = "The first and the last passes; all of them stand in iterations.csv."
SHARES = (
    "Control points keep the coordinates that were given; the others took their share "
    "of the differences (distributed_easting, distributed_northing)."
)
BEFORE = "paper and internal are figures before the distribution"
FIGURES = f"{BEFORE}; the propagated one is that after it."


def iterations(facts) -> Section:
    """Set the moves of every further pass."""
    if facts is None:
        return NO_SECTION
    moves = _shown(facts.moves)
    largest, rms = (lengths([move[k] for move in moves]) for k in (1, 3))
    rows = tuple(
        (f"{number:d}", most, printable(point), mean)
        for (number, _, point, _), most, mean in zip(moves, largest, rms, strict=True)
    )
    cut = (CUT,) if len(moves) < len(facts.moves) else ()
    return Section(
        "Iterations: moves of the points (total)",
        ("pass", "largest", "at point", "RMS"),
        rows,
        (*cut, _end(facts), _held(facts), *_precision(facts)),
    )


def _shown(moves):
    if len(moves) <= MOST_SHOWN:
        return moves
    half = MOST_SHOWN // 2
    return (*moves[:half], *moves[-half:])


def _end(facts):
    if facts.is_converged:
        return f"Ended, since no point moved by {length(facts.least_move)}."
    return (
        f"Not at its end after {count(facts.most_passes, 'pass', 'passes')}: "
        "points still move."
    )


def _held(facts):
    return (
        f"{count(facts.n_held, 'control point')} held at given coordinates; "
        f"{facts.n_models_held} of {count(facts.n_models, 'model')} have one."
    )


def _precision(facts):
    """The propagated figure of one pass beside that of all."""
    if not math.isfinite(facts.total_of_one_pass + facts.total):
        return ()
    before, after = lengths([facts.total_of_one_pass, facts.total])
    return (f"Propagated: {before} after one pass, {after} after the last.",)


def distribution(facts) -> Section:
    """Set how far points of each role were moved."""
    if facts is None:
        return NO_SECTION
    rows = tuple(
        (f"{role} points", f"{n_points:d}", *lengths([rms, most]))
        for role, n_points, rms, most in facts.moves
    )
    return Section(
        f"Residuals of control, distributed by {facts.way.replace('_', ' ')} (total)",
        ("", "points", "moved, RMS", "at most"),
        rows,
        (SHARES, FIGURES if facts.is_propagated else f"{BEFORE}."),
    )
