"""How far points were moved: by iterations, and by the distribution of residuals."""

import math

from einschalt.foundations.display_names import printable
from einschalt.foundations.language import figure, mark, mark_each, translated
from einschalt.foundations.typesetting import length, lengths
from einschalt.pipeline.summary.section import NO_SECTION, Section

MOST_SHOWN = 8
CUT = mark("The first and the last passes; iterations.csv has all of them.")
CONVERGED = mark("Converged: no point moved by {length}.")
NOT_CONVERGED = mark("Not converged after {n:pass|passes}: points are still moving.")
HELD = mark(
    "{n:control point|control points} held at given coordinates; {n_models} of "
    "{n_all:model has|models have} at least one."
)
PROPAGATED = mark("Propagated: {before} after one pass, {after} after the last.")
SHARES = mark(
    "Control points keep their given coordinates; the other points took their share of "
    "the differences (distributed_easting, distributed_northing)."
)
BEFORE = mark("paper and internal are figures before the distribution.")
FIGURES = mark(
    "paper and internal are figures before the distribution; the propagated one is "
    "that after it."
)
POINTS_OF_ROLE = mark_each(
    {"new": "new points", "control": "control points", "check": "check points"}
)
WAYS = mark_each(
    {
        "natural_neighbour": (
            "Residuals of control, distributed by natural neighbours (total)"
        ),
        "inverse_distance": (
            "Residuals of control, distributed by inverse distance (total)"
        ),
        "multiquadric": "Residuals of control, distributed by multiquadrics (total)",
    }
)


def iterations(facts) -> Section:
    """Set the moves of every further pass."""
    if facts is None:
        return NO_SECTION
    moves = _shown(facts.moves)
    largest, rms = (lengths([move[k] for move in moves]) for k in (1, 3))
    rows = tuple(
        (figure(number, "d"), most, printable(point), mean)
        for (number, _, point, _), most, mean in zip(moves, largest, rms, strict=True)
    )
    cut = (translated(CUT),) if len(moves) < len(facts.moves) else ()
    header = (translated("pass"), translated("largest"), translated("at point"), "RMS")
    return Section(
        translated("Iterations: moves of the points (total)"),
        header,
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
        return translated(CONVERGED, length=length(facts.least_move))
    return translated(NOT_CONVERGED, n=facts.most_passes)


def _held(facts):
    models = {"n_models": facts.n_models_held, "n_all": facts.n_models}
    return translated(HELD, n=facts.n_held, **models)


def _precision(facts):
    """The propagated figure of one pass beside that of all."""
    if not math.isfinite(facts.total_of_one_pass + facts.total):
        return ()
    before, after = lengths([facts.total_of_one_pass, facts.total])
    return (translated(PROPAGATED, before=before, after=after),)


def distribution(facts) -> Section:
    """Set how far points of each role were moved."""
    if facts is None:
        return NO_SECTION
    rows = tuple(
        (
            translated(POINTS_OF_ROLE[role]),
            figure(n_points, "d"),
            *lengths([rms, most]),
        )
        for role, n_points, rms, most in facts.moves
    )
    titles = translated("points"), translated("moved, RMS"), translated("at most")
    figures = translated(FIGURES if facts.is_propagated else BEFORE)
    remarks = (translated(SHARES), figures)
    return Section(translated(WAYS[facts.way]), ("", *titles), rows, remarks)
