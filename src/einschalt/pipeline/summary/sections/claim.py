"""Whether the claimed figure stands against what was measured."""

from einschalt.foundations.typesetting import fixed, length, lengths
from einschalt.pipeline.summary.section import NO_SECTION, Section
from einschalt.pipeline.summary.wording import probability

HEADER = ("", "points", "measured", "predicted", "P")
P = (
    "P: probability of as much where the claim holds; below 0.01 for all tests "
    "together (Holm) it does not stand."
)
ASSUMED = {
    "independent_approximations": (
        "Predicted for approximate coordinates whose errors are independent of each "
        "other."
    ),
    "perfect_orientations": "Predicted for models whose orientation has no error.",
}


def section(claim) -> Section:
    """Set measured quantities beside what the claim predicts."""
    assumed = (ASSUMED[claim.assumption],) if claim.is_assumed else ()
    said = (*assumed, P, *_three_figures(claim))
    return Section("Does the claim stand? (total, RMS)", HEADER, _rows(claim), said)


def heights(claim) -> Section:
    """The same of heights, where they were tested."""
    if not claim.tests:
        return NO_SECTION
    return Section("Do the heights stand? (RMS)", HEADER, _rows(claim), (P,))


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
            (test.name, f"{test.n_points:d}", *shown, probability(test.p_value))
        )
    return tuple(rows)


def _three_figures(claim):
    """Coverage differences against each of the three figures."""
    if (paper := claim.paper) is None:
        return ()
    said = [
        f"{length(paper.predicted)} (P {probability(paper.p_value)}) after the paper"
    ]
    ours = claim.of("coverage differences")
    if ours is not None and not claim.is_assumed:
        said.insert(
            0, f"{length(ours.predicted)} (P {probability(ours.p_value)}) propagated"
        )
    should = ", ".join(said)
    text = f"Coverage differences are {length(paper.observed)} and should be {should}"
    return (f"{text}; the internal figure is made of them.",)
