"""Whether the measurements support the stated precision."""

import math

from einschalt.foundations.language import figure, mark, mark_each, translated
from einschalt.foundations.typesetting import fixed, length, lengths
from einschalt.pipeline.summary.section import NO_SECTION, Section
from einschalt.pipeline.summary.wording import probability

P = mark(
    "P: probability of a value this large if the stated precision is correct (near 1: "
    "smaller than predicted); it is rejected if P is below {level} for all tests "
    "together (Holm)."
)
LEVEL = 0.01
ASSUMED = mark_each(
    {
        "independent_approximations": (
            "Predicted for approximate coordinates with mutually independent errors."
        ),
        "perfect_orientations": "Predicted for models with error-free orientation.",
    }
)
NO_REGIONS = mark_each(
    {
        "orientations": (
            "Not tested: whether the given coordinates of a region are displaced "
            "together, since errors of the orientations bend models, which looks alike."
        ),
        "too_many": (
            "Not tested: whether the given coordinates of a region are displaced "
            "together, since there are too many points for the test."
        ),
    }
)
SEEN_FROM = mark(
    "Neighbouring given coordinates, a tenth of all or more, that are displaced "
    "together would be noticed from {median} on, at the least favourable place from "
    "{largest} on. A smaller displacement may pass unnoticed, and points there are off "
    "by as much."
)
SEEN_IN_PARTS = mark(
    "Neighbouring given coordinates, a tenth of all or more, that are displaced "
    "together would be noticed from {median} on; parts of the block that hardly "
    "anything connects may be displaced unnoticed."
)
SEEN_NOWHERE = mark(
    "Neighbouring given coordinates that are displaced together would not be noticed: "
    "hardly anything connects the models."
)
# of what is measured beside what was predicted
BY_PROPAGATION = mark("{length} by propagation (P {p})")
BY_BUDGET = mark("{length} by Kovarik's budget (P {p})")


def section(claim) -> Section:
    """Set measured quantities beside what the stated precision predicts."""
    assumed = (translated(ASSUMED[claim.assumption]),) if claim.is_assumed else ()
    remarks = (*assumed, _meaning_of_p(), *_three_figures(claim))
    if claim.untested_regions:
        remarks = (*remarks, translated(NO_REGIONS[claim.untested_regions]))
    if claim.detectable_shift is not None:
        remarks = (*remarks, _seen_from(claim.detectable_shift))
    title = translated("Is the stated precision supported? (total, RMS)")
    return Section(title, _header(), _rows(claim), remarks)


def _seen_from(shift):
    if not math.isfinite(shift.median):
        return translated(SEEN_NOWHERE)
    if not math.isfinite(shift.largest):
        return translated(SEEN_IN_PARTS, median=length(shift.median))
    median, largest = lengths([shift.median, shift.largest])
    return translated(SEEN_FROM, median=median, largest=largest)


def heights(claim) -> Section:
    """The same of heights, where they were tested."""
    if not claim.tests:
        return NO_SECTION
    title = translated("Is the stated precision of the heights supported? (RMS)")
    return Section(title, _header(), _rows(claim), (_meaning_of_p(),))


def _header():
    return (
        "",
        translated("points"),
        translated("measured"),
        translated("predicted"),
        "P",
    )


def _meaning_of_p():
    return translated(P, level=figure(LEVEL))


def _rows(claim):
    measured = lengths([t.observed for t in claim.tests if t.is_length])
    predicted = lengths([t.predicted for t in claim.tests if t.is_length])
    texts = iter(zip(measured, predicted, strict=True))
    rows = []
    for test in claim.tests:
        shown = (
            next(texts)
            if test.is_length
            else (fixed(test.observed, 2), fixed(test.predicted, 2))
        )
        rows.append(
            (
                translated(test.name),
                figure(test.n_points, "d"),
                *shown,
                probability(test.p_value),
            )
        )
    return tuple(rows)


def _three_figures(claim):
    """Coverage differences against each of the three figures."""
    if (paper := claim.paper) is None:
        return ()
    expected = [_expected(BY_BUDGET, paper)]
    ours = claim.of("coverage differences")
    if ours is not None and not claim.is_assumed:
        expected.insert(0, _expected(BY_PROPAGATION, ours))
    message = mark(
        "Coverage differences are {observed}; expected {expected}. The internal figure "
        "is computed from them."
    )
    observed = length(paper.observed)
    return (translated(message, observed=observed, expected=", ".join(expected)),)


def _expected(message, test):
    p = probability(test.p_value)
    return translated(message, length=length(test.predicted), p=p)
