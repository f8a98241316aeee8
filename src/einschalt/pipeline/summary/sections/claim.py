"""Whether the claimed figure stands against what was measured."""

import numpy as np

from einschalt.foundations.typesetting import fixed, length, lengths, number
from einschalt.pipeline.summary.sections.section import Section

P = (
    "P: probability of as much where the claim holds; below 0.01 for all tests "
    "together (Holm) it does not stand."
)
GIVEN = (
    "Predicted for approximate coordinates whose errors are independent of each other."
)
ORIENTED = "Predicted for models whose orientation has no error."
LEAST_SHOWN = 0.001


def section(result) -> Section:
    """Measured quantities beside what the claim predicts; no rows without a claim."""
    claim = result.claim
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
    said = [P, *_three_figures(result)]
    if claim.is_assumed:
        said.insert(0, GIVEN if result.high is None else ORIENTED)
    return Section(
        "Does the claim stand? (total, RMS)",
        ("", "points", "measured", "predicted", "P"),
        tuple(rows),
        tuple(said),
    )


def probability(p_value):
    """Write a probability with two digits; a very small one as less than 0.001."""
    if not np.isfinite(p_value):
        return "–"
    return "< 0.001" if p_value < LEAST_SHOWN else number(min(p_value, 0.99))


def _three_figures(result):
    """Coverage differences against each of the three figures."""
    paper = result.claim.paper
    if paper is None:
        return ()
    said = [
        f"{length(paper.predicted)} (P {probability(paper.p_value)}) after the paper"
    ]
    ours = result.claim.of("coverage differences")
    if ours is not None and not result.claim.is_assumed:
        said.insert(
            0, f"{length(ours.predicted)} (P {probability(ours.p_value)}) propagated"
        )
    should = ", ".join(said)
    text = f"Coverage differences are {length(paper.observed)} and should be {should}"
    return (f"{text}; the internal figure is made of them.",)
