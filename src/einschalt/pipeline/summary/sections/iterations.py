"""How far points moved while the low flight was repeated on its own coordinates."""

import numpy as np
import pandas as pd

from einschalt.foundations.display_names import printable
from einschalt.foundations.typesetting import count, length, lengths
from einschalt.pipeline.assessment.findings.iterations import total_of_one_pass
from einschalt.pipeline.densification.iteration import LEAST_MOVE
from einschalt.pipeline.summary.sections.section import Section

MOST_SHOWN = 8
CUT = "The first and the last passes; all of them stand in iterations.csv."


def section(result) -> Section:
    """Moves of every further pass; no rows without iteration."""
    everything = result.iterations
    if everything.empty:
        return Section("", (), ())
    moves = _shown(everything)
    is_cut = len(moves) < len(everything)
    largest, rms = lengths(moves["largest_move"]), lengths(moves["move_rms"])
    rows = [
        (f"{number:d}", most, printable(name), mean)
        for number, most, name, mean in zip(
            moves["iteration"], largest, moves["point_id"], rms, strict=True
        )
    ]
    return Section(
        "Iterations: moves of the points (total)",
        ("pass", "largest", "at point", "RMS"),
        tuple(rows),
        (
            *((CUT,) if is_cut else ()),
            _end(result),
            _held(result.iteration),
            *_precision(result),
        ),
    )


def _shown(moves):
    if len(moves) <= MOST_SHOWN:
        return moves
    half = MOST_SHOWN // 2
    return pd.concat([moves.head(half), moves.tail(half)])


def _end(result):
    if result.iteration.is_converged:
        return f"Ended, since no point moved by {length(LEAST_MOVE)}."
    return (
        f"Not at its end after {count(result.settings.iterations, 'pass', 'passes')}: "
        "points still move."
    )


def _held(iteration):
    return (
        f"{count(iteration.n_held, 'control point')} held at given coordinates; "
        f"{iteration.n_models_held} of {count(iteration.n_models, 'model')} have one."
    )


def _precision(result):
    """The propagated figure of one pass beside that of all."""
    once, now = total_of_one_pass(result), result.figures.mean_total
    if not (np.isfinite(once) and np.isfinite(now)):
        return ()
    before, after = lengths([once, now])
    return (f"Propagated: {before} after one pass, {after} after the last.",)
