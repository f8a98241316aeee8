"""A batch of blocks: the table of what became of each, and what moved since last time.

Outcomes: ``done`` (computed in this run, or by the interrupted run that it continues),
``skipped`` (nothing has changed since its result was computed), ``failed``.
"""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from einschalt.foundations.display_names import as_unicode, printable, shortened
from einschalt.foundations.errors import BlockError, EinschaltError
from einschalt.foundations.kept_texts import kept, retold
from einschalt.foundations.language import mark, mark_each, translated
from einschalt.foundations.typesetting import length
from einschalt.foundations.typesetting import seconds as duration

DONE, SKIPPED, FAILED = "done", "skipped", "failed"
CLAIM = "claim_is_supported"
TEXT_COLUMNS = ("block", "outcome", "stage", "reason", "remedy")
FIGURES = {
    "n_points": "n_points",
    "standard_error_total": "mean_total",
    "standard_error_paper": "mean_paper",
    "standard_error_internal": "mean_internal",
}
# of what the result is judged by
JUDGED = {"standard_error_credible": "credible", "claim_is_supported": CLAIM}
COUNTS = ("n_points", "n_suspects", "n_failed_models", "n_moved")
COLUMNS = (
    *(*TEXT_COLUMNS, *FIGURES, "seconds"),
    *("n_suspects", "n_failed_models", "n_moved", "largest_move", *JUDGED),
)
POSITION = ("point_id", "easting", "northing", "height")
SAME = 1e-3  # coordinates that differ by less are the same [m]
CHANGES_OF_POINTS = MOVED, NEW, GONE = "moved", "new", "gone"
UNCHANGED = "unchanged"
AND_MORE = mark("{reason} (and {n:more problem|more problems}: see failure.json)")
NOT_ASKED = "only blocks that failed were asked for"
MOST_SAID = 10
OUTCOMES = mark_each({DONE: "{n} done", SKIPPED: "{n} skipped", FAILED: "{n} failed"})
MOVED_FAR = mark("Moved by more than their standard error since the previous run")
REFUTED = mark("Stated precision not supported: see their reports")
LONGEST_REASON = 300  # characters of what libraries say


def row_of_figures(
    name, outcome, figures, seconds, changes=None, largest_move=None
) -> dict:
    """Row of a block whose result is there.

    ``figures`` as provenance.json has them; ``changes`` of :func:`compare_points` and
    ``largest_move`` of :func:`largest_move_of`, left out where there was nothing to
    compare with.
    """
    # results of an earlier version were not judged
    row = {column: figures.get(key) for column, key in (FIGURES | JUDGED).items()}
    if changes is not None:
        is_moved = changes["change"] == MOVED
        row["n_moved"] = int(is_moved.sum())
        row["largest_move"] = largest_move
    return {
        **row,
        "block": name,
        "outcome": outcome,
        "reason": UNCHANGED if outcome == SKIPPED else "",
        "seconds": seconds,
        "n_suspects": figures.get("n_suspects"),
        "n_failed_models": figures.get("n_failed"),
    }


def row_of_failure(name, error, stage, seconds=None) -> dict:
    """Row of a block that failed, in ``stage`` unless the error knows better."""
    reason, remedy = _reason_and_remedy(error)
    return {
        "block": name,
        "outcome": FAILED,
        "stage": getattr(error, "stage", None) or stage,
        "reason": reason,
        "remedy": remedy,
        "seconds": seconds,
    }


def _reason_and_remedy(error):
    if isinstance(error, BlockError):
        first = error.problems[0]
        more = sum(problem.stands_for for problem in error.problems) - 1
        reason, remedy = _reason_and_remedy(first)
        return (kept(AND_MORE, reason=reason, n=more) if more else reason), remedy
    if isinstance(error, EinschaltError):
        text = f"{error.where}: {error.found}" if error.where else error.found
        expected = f"; expected {error.expected}" if error.expected else ""
        return f"{text}{expected}", error.remedy
    if isinstance(error, MemoryError):
        return (
            "needs more memory than there is",
            "Run it with fewer processes, with a higher limit, or on a larger computer",
        )
    return (
        shortened(f"{type(error).__name__}: {error}", LONGEST_REASON),
        "This is a fault of the program: please report it with failure.json",
    )


def blocks_table(rows) -> pd.DataFrame:
    """Table of a batch: one row per block, in the order of the rows.

    Standard errors are RMS over the new points, TOTAL [m]. n_moved counts the points
    that moved by more than their standard error since the run before; largest_move is
    that of any point, moved so far or not [m]. standard_error_credible is the figure
    to believe, a lower bound where claim_is_supported is False: something contradicts
    the claim; it is None where nothing tests the claim, or the result is of an earlier
    version.
    """
    rows = list(rows)
    columns = {}
    for name in COLUMNS:
        values = [row.get(name) for row in rows]
        if name in TEXT_COLUMNS:
            texts = [as_unicode(value or "") for value in values]
            columns[name] = pd.Series(texts, dtype=object)
        elif name == CLAIM:  # true, false, or nothing where there is no result
            columns[name] = pd.Series(values, dtype=object)
        else:
            kind = "Int64" if name in COUNTS else float
            columns[name] = pd.Series(values, dtype=float).astype(kind)
    return pd.DataFrame(columns)


def compare_points(points, previous) -> pd.DataFrame:
    """Points that moved by more than their standard error, came, or went.

    point_id, change, easting, northing (new; of a point that is gone the old ones),
    moved_easting, moved_northing, moved_total [m], standard_error_total: what the point
    claims (propagated; where that is not known after Kovarik's budget, else internal).
    A height that moved by more than its standard error counts as well. A point that
    claims nothing has moved where its coordinates differ by more than a millimetre.
    """
    both = _beside(points, previous)
    claimed = _claimed(both)
    moved = _moves(both)
    total = np.hypot(*moved.values())
    is_moved = (both["side"] == "both") & (
        (total > claimed.fillna(SAME)) | _is_lifted(both)
    )
    change = np.select(
        [is_moved, both["side"] == "left_only", both["side"] == "right_only"],
        CHANGES_OF_POINTS,
        "",
    )
    table = pd.DataFrame(
        {
            "point_id": both["point_id"].astype(str),
            "change": change,
            "easting": both["easting"].fillna(both["easting_before"]),
            "northing": both["northing"].fillna(both["northing_before"]),
            **moved,
            "moved_total": total,
            "standard_error_total": claimed,
        }
    )
    table = table[table["change"] != ""]
    return table.sort_values("point_id", kind="stable").reset_index(drop=True)


def largest_move_of(points, previous) -> float:
    """Largest movement in plan of the points that both runs have [m].

    Of those within their standard error as well; NaN if no point is in both.
    """
    moves = _moves(_beside(points, previous)).values()
    return float(pd.Series(np.hypot(*moves)).max())


def _beside(points, previous):
    """Points with their earlier coordinates, and with those that came or went."""
    # what the earlier result claims must not stand in for what this one does not say
    before = previous[[name for name in POSITION if name in previous]]
    return points.merge(
        before, on="point_id", how="outer", suffixes=("", "_before"), indicator="side"
    )


def _moves(both):
    return {
        f"moved_{axis}": both[axis] - both[f"{axis}_before"]
        for axis in ("easting", "northing")
    }


def _claimed(both):
    claimed = pd.Series(np.nan, index=both.index)
    for kind in ("total", "paper", "internal"):
        name = f"standard_error_{kind}"
        if name in both:
            claimed = claimed.fillna(both[name])
    return claimed


def _is_lifted(both):
    if not {"height", "height_before", "standard_error_height"} <= set(both):
        return np.zeros(len(both), dtype=bool)
    lift = (both["height"] - both["height_before"]).abs()
    return (lift > both["standard_error_height"].fillna(SAME)).to_numpy()


@dataclass
class Expectation:
    """When a batch will end, from the size of what is done and of what is left."""

    total: float  # size of all that is to be done; any unit
    done: float = 0.0

    def seconds_left(self, seconds_so_far):
        """Seconds until the end, None where nothing can be said yet."""
        if self.done <= 0.0:
            return None
        return seconds_so_far * max(self.total - self.done, 0.0) / self.done


def summarize_batch(table, seconds) -> str:
    """Write what a batch says at its end, with the time of the whole run."""
    lines = [
        translated(
            "{n:block|blocks}: {outcomes} ({time})",
            n=len(table),
            outcomes=outcomes_text(table),
            time=duration(seconds),
        )
    ]
    failed = table[table["outcome"] == FAILED]
    if len(failed):
        lines += ["", translated("Failed blocks")]
        for row in failed.head(MOST_SAID).itertuples():
            lines.append(f"  {printable(row.block)}: {retold(printable(row.reason))}.")
            if row.remedy:
                lines.append(f"    {retold(printable(row.remedy))}")
        lines += _rest(failed)
    lines += _refuted(table)
    moved = table[table["n_moved"].fillna(0) > 0]
    moved = moved.sort_values("largest_move", ascending=False, kind="stable")
    if len(moved):
        lines += ["", translated(MOVED_FAR)]
        for row in moved.head(MOST_SAID).itertuples():
            facts = {"n": int(row.n_moved), "most": length(row.largest_move)}
            text = translated("{n:point|points}, at most {most}", **facts)
            lines.append(f"  {printable(row.block)}: {text}")
        lines += _rest(moved)
    return "\n".join(lines)


def outcomes_text(table) -> str:
    """Say how many blocks had which outcome."""
    numbers = table["outcome"].value_counts()
    return ", ".join(
        translated(OUTCOMES[outcome], n=int(numbers[outcome]))
        for outcome in OUTCOMES
        if numbers.get(outcome)
    )


def refuted(table):
    """Rows of blocks whose claim does not stand, the worst first."""
    rows = table[table[CLAIM].isin([False])]
    return rows.sort_values("standard_error_credible", ascending=False, kind="stable")


def untested(table):
    """Names of blocks with a result whose claim nothing has tested."""
    has_result = table["outcome"] != FAILED
    return table.loc[has_result & table[CLAIM].isna(), "block"].tolist()


def _refuted(table):
    rows = refuted(table)
    if rows.empty:
        return []
    lines = ["", translated(REFUTED)]
    for row in rows.head(MOST_SAID).itertuples():
        figure = row.standard_error_credible
        text = translated("not known")
        if np.isfinite(figure):
            text = translated("{length} or worse (total)", length=length(figure))
        lines.append(f"  {printable(row.block)}: {text}")
    return lines + _rest(rows)


def _rest(rows):
    rest = len(rows) - MOST_SAID
    return [translated("  and {n} more", n=rest)] if rest > 0 else []
