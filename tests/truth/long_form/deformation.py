"""Are deformations that models share found, and is it better to model them?

Both ways on simulated Neukirchen whose low flight, or both flights, are deformed by 4
to 5 cm in the middle of the models and 15 at the edge; and blocks without deformation.
"""

from dataclasses import replace

import numpy as np
from tests.truth.long_form.figures import Figure, Table, of_blocks, root_of_ratio

from einschalt.pipeline.densify import densify
from einschalt.pipeline.settings import Settings
from einschalt.pipeline.simulation.simulate_block import PRESETS, simulate_block

N_BLOCKS = 20
N_SMALL = 800
# 15 cm at the edge, at 1:8000 and at 1:15 000
LOW_UM, HIGH_UM = 18.75, 10.0
DEFORMED = {
    "none": {},
    "low flight": {"low_deformation_um": LOW_UM},
    "both flights": {"low_deformation_um": LOW_UM, "high_deformation_um": HIGH_UM},
}
WAYS = ("modelled", "ignored", "two steps")
PLANE = ["easting", "northing"]


def tables():
    """Run the study.

    Returns
    -------
    list of Table
    """
    rows = []
    for name, study in _STUDIES.items():
        blocks = of_blocks(study, range(N_BLOCKS))
        is_deformed = bool(DEFORMED[name])
        found = {"low": 1.0} if is_deformed else {"high": 0.05}
        better = [b["modelled"] < b["two steps"] for b in blocks]
        rows.append(
            (
                name,
                Figure(np.mean([b["is_found"] for b in blocks]), **found, form=".2f"),
                *(_root_mean_square([b[way] for b in blocks]) for way in WAYS),
                Figure(np.mean(better), low=1.0, form=".2f"),
                Figure(np.mean([b["s_0"] for b in blocks]), form=".2f"),
            )
        )
    alarms = of_blocks(false_alarm, range(N_SMALL))
    return [
        Table(
            f"Deformations that models share, {N_BLOCKS} blocks of neukirchen",
            "RMS of the total errors of all points [m]: simultaneous with the "
            "deformation modelled if the test finds it, simultaneous without, and in "
            "two steps. The deformation must be found in every block that has it, and "
            "in at most 5 % of those that have none; with the deformation modelled, "
            "every block must be better than in two steps. s_0 is that of the "
            "adjustment that ignores it.",
            ("deformed", "found", *WAYS, "better than two steps", "s_0 ignored"),
            rows,
        ),
        Table(
            f"False alarms of the deformation test, {N_SMALL} blocks of demo",
            "Share of the blocks without deformation in which the test of a flight has "
            "p below 0.05, which must be within the limits of chance with the "
            "probability 0.001, and share in which the default settings (0.001) would "
            "model one.",
            ("flight", "p < 0.05", "modelled"),
            [
                (
                    name,
                    _level([a[name] < 0.05 for a in alarms]),
                    Figure(np.mean([a[name] < 0.001 for a in alarms]), high=0.05),
                )
                for name in ("high flight", "low flight")
            ],
        ),
    ]


def study(seed, noise):
    """Adjust one block in all ways.

    Parameters
    ----------
    seed : int
    noise : dict
        Deformations of its flights.

    Returns
    -------
    dict
    """
    noise = replace(PRESETS["neukirchen"].noise, **noise)
    block = simulate_block("neukirchen", seed=seed, noise=noise)
    modelled = densify(block, Settings(method="simultaneous"))
    ignored = densify(
        block, Settings(method="simultaneous", model_deformation="ignored")
    )
    found = modelled.simultaneous.deformations.set_index("flight")["is_detected"]
    return {
        "is_found": bool(found["low_flight"]),
        "modelled": _squares(modelled.points, block.truth),
        "ignored": _squares(ignored.points, block.truth),
        "two steps": _squares(modelled.two_step.points, block.truth),
        "s_0": ignored.simultaneous.s_0,
    }


def without_deformation(seed):
    """:func:`study` of a block whose models are not deformed."""
    return study(seed, DEFORMED["none"])


def with_deformed_low_flight(seed):
    """:func:`study` of a block whose low flight is deformed."""
    return study(seed, DEFORMED["low flight"])


def with_both_deformed(seed):
    """:func:`study` of a block whose flights are both deformed."""
    return study(seed, DEFORMED["both flights"])


_STUDIES = dict(
    zip(
        DEFORMED,
        (without_deformation, with_deformed_low_flight, with_both_deformed),
        strict=True,
    )
)


def false_alarm(seed):
    """p of both flights of a small block without deformation.

    Parameters
    ----------
    seed : int

    Returns
    -------
    dict
    """
    settings = Settings(method="simultaneous", model_deformation="tested")
    found = densify(simulate_block("demo", seed=seed), settings).simultaneous
    names = found.deformations["flight"].str.replace("_", " ")
    return dict(zip(names, found.deformations["p_value"], strict=True))


def _squares(points, truth):
    """Mean square of the total errors [m²]."""
    true = truth.set_index("point_id").loc[points["point_id"], PLANE].to_numpy()
    return float(np.mean(((points[PLANE].to_numpy() - true) ** 2).sum(axis=1)))


def _root_mean_square(squares):
    return root_of_ratio(squares, np.ones(len(squares)), form=".4f")


def _level(is_refused):
    chance = 3.3 * np.sqrt(0.05 * 0.95 / N_SMALL)
    error = np.std(is_refused) / np.sqrt(N_SMALL)
    return Figure(
        np.mean(is_refused), error, low=0.05 - chance, high=0.05 + chance, form=".3f"
    )
