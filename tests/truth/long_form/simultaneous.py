"""Does the simultaneous adjustment reach what it claims?

All models of both flights and the control at once, with and without a film affinity
that all models share.
"""

from dataclasses import dataclass, field, replace

import numpy as np
from tests.truth.long_form.calibration import (
    HEAD,
    errors_of,
    figures_of,
    sums_of,
)
from tests.truth.long_form.figures import Figure, Table, of_blocks, root_of_ratio

from einschalt.pipeline.adjust_block import FILM_AFFINITY, adjust_block
from einschalt.pipeline.simulation.simulate_block import PRESETS, simulate_block

# 20 would know the squared error to 0.02 only: the points of a block hang together
N_BLOCKS = 100
FILM = 2e-4
REACHED_CM = {"low": 2.6, "high": 2.8}
LOSS = {"low": 0.97, "high": 1.03}
NONE, COMMON = "none", "helmert with common affinity"


@dataclass(frozen=True)
class Case:
    """A block and how it is adjusted.

    Attributes
    ----------
    film : float
    kind : str
        Transformation of the models.
    bounds : dict
        Of the error of the points [cm].
    is_modelled : bool
        Whether the models take the film up.
    """

    film: float
    kind: str
    bounds: dict = field(default_factory=dict)
    is_modelled: bool = True

    @property
    def titles(self):
        """What stands in the table."""
        film = "2 · 10⁻⁴" if self.film else NONE
        kind = COMMON if self.kind == FILM_AFFINITY else self.kind
        return film, kind


CASES = {
    "affine": Case(0.0, "affine", REACHED_CM),
    "affine, film": Case(FILM, "affine", REACHED_CM),
    "helmert": Case(0.0, "helmert"),
    "helmert, film": Case(FILM, "helmert", is_modelled=False),
    "common affinity, film": Case(FILM, FILM_AFFINITY),
}


def tables():
    """Run the study.

    Returns
    -------
    list of Table
    """
    blocks = of_blocks(study, range(N_BLOCKS))
    return [
        Table(
            f"Simultaneous adjustment, {N_BLOCKS} blocks of the preset neukirchen",
            "Root mean square of the total errors of all points: 2.7 ± 0.1 cm with "
            "affine models; an independent simulation of the same area has 2.73. "
            "Helmert models with one common affinity per flight must be within 3 % "
            "of helmert models of film without affinity. If the models absorb the "
            "film affinity, the table also gives the mean squared error over its "
            "covariance, divided by 2 (0.97 to 1.03), the share of points in their "
            "95 % ellipse (0.940 to 0.960), and the ratio of claimed to true error "
            "(0.98 to 1.02).",
            ("film affinity", "models", "error [cm]", "to helmert without", *HEAD),
            [_row(name, case, blocks) for name, case in CASES.items()],
        )
    ]


def study(seed, cases=tuple(CASES)):
    """Adjust one block in all ways.

    Parameters
    ----------
    seed : int
    cases : sequence of str

    Returns
    -------
    dict of str to ndarray
        Sums over the points, as :func:`calibration.sums_of` has them.
    """
    sums = {}
    for name in cases:
        case = CASES[name]
        noise = replace(PRESETS["neukirchen"].noise, film_affinity=case.film)
        block = simulate_block("neukirchen", seed=seed, noise=noise)
        points = adjust_block(block, kind=case.kind).points
        covariance = np.empty((len(points), 2, 2))
        covariance[:, 0, 0] = points["standard_error_easting"] ** 2
        covariance[:, 1, 1] = points["standard_error_northing"] ** 2
        covariance[:, 0, 1] = covariance[:, 1, 0] = points["covariance_en"]
        sums[name] = sums_of(errors_of(points, block.truth), covariance)
    return sums


def root_mean_square_cm(sums, **bounds):
    """Total error of all points of many blocks [cm], a Figure."""
    count, *_, squares = np.transpose(sums)
    found = root_of_ratio(1e4 * squares, count)
    # a length, known to 1 % of it
    error = found.error / found.value
    return Figure(found.value, error, **bounds, form=".2f")


def _row(name, case, blocks):
    sums = [block[name] for block in blocks]
    loss = ""
    if case.kind != "affine":
        without = [block["helmert"][-1] for block in blocks]
        bounds = LOSS if case.kind == FILM_AFFINITY else {}
        loss = root_of_ratio([s[-1] for s in sums], without, **bounds)
    error = root_mean_square_cm(sums, **case.bounds)
    return (*case.titles, error, loss, *figures_of(sums, judged=case.is_modelled))
