"""Models that an adjustment of a block leaves out: why, and how to mend it."""

import numpy as np

from einschalt.foundations import typesetting
from einschalt.stages.transformation_kinds import SPATIAL, more_points_for
from einschalt.theory.block_adjustment import determinacy

STAGE = "simultaneous_adjustment"
MOVES_FREELY = (
    "it can move against the rest of the block: too few points tie it, or the part it "
    "belongs to"
)
LOOK_FOR_ERRORS = "Look for exchanged names and gross errors in it, or leave it out"
WITHOUT_NUMBERS = {
    determinacy.LOOSE: (
        MOVES_FREELY,
        "Measure more points that tie it to its neighbours, or give it control points",
    ),
    determinacy.CONTRADICTED: (
        "most of its measurements contradict the rest of the block",
        LOOK_FOR_ERRORS,
    ),
    determinacy.RESTLESS: ("its position does not converge", LOOK_FOR_ERRORS),
}


def failed_models(tables, verdicts):
    """Rows of ``failures``: what could not be determined, and how to mend it."""
    failed = np.flatnonzero(~verdicts.is_fine)
    names = tables.models.iloc[failed][["flight", "coverage", "model_id"]]
    return [
        (*name, STAGE, *why_failed(verdicts, model, tables.kind[model]))
        for model, name in zip(failed, names.to_numpy().tolist(), strict=True)
    ]


def _part_sizes(verdicts):
    """Number of models that hang together with each model; 0 for single ones."""
    is_in_part = verdicts.part >= 0
    sizes = np.zeros(len(verdicts.part), dtype=np.int64)
    part = verdicts.part[is_in_part]
    sizes[is_in_part] = np.bincount(part)[part]
    return sizes


def why_failed(verdicts, model, kind):
    """Why a model could not be determined, and how to mend it."""
    needs = determinacy.LEAST_POINTS[kind != "helmert"]
    n_ties, n_control = int(verdicts.n_ties[model]), int(verdicts.n_control[model])
    verdict = int(verdicts.verdict[model])
    if verdict in WITHOUT_NUMBERS:
        return WITHOUT_NUMBERS[verdict]
    shared = "common with other models or the control"
    if verdict == determinacy.FEW_TIES:
        return (
            f"{_points(n_ties)} {shared}, but {kind} needs {needs}",
            more_points_for(kind),
        )
    if verdict == determinacy.TIES_ON_LINE:
        return (
            f"its points {shared} lie on a line or in one place",
            "Measure a common point away from that line",
        )
    together = typesetting.count(_part_sizes(verdicts)[model], "model")
    part = f"the part of the block it belongs to, {together},"
    if verdict == determinacy.NO_CONTROL:
        has = _points(n_control, "control point")
        if kind == SPATIAL:  # others hold it in plan
            has += " with a height" if n_control == 1 else " with heights"
        return (
            f"{part} has {has}, but {kind} needs {needs}",
            "Tie it to the rest of the block, or give it control points",
        )
    return (
        f"the control of {part[:-1]}, lies on a line or in one place",
        "Give it a control point away from that line",
    )


def _points(count, noun="point"):
    return f"{count or 'no'} {noun}{'' if count == 1 else 's'}"
