"""Are the sizes of errors that the data show those that they have?

Variance components of control and of both flights against the simulation, and whether
an m_g that was typed wrongly is called out.
"""

from dataclasses import replace

import numpy as np
from scipy.stats import binom
from tests.truth.long_form.figures import Figure, Table, of_blocks

from einschalt.pipeline.assessment.findings.suspects import wrong_measuring_errors
from einschalt.pipeline.block.block import Block, plain_fields
from einschalt.pipeline.densify import densify
from einschalt.pipeline.simulation.simulate_block import simulate_block

N_BLOCKS = 50
WRONG_BY = 1.5
SOURCES = {"control": 0.03, "high_flight": 7.5, "low_flight": 5.0}
FLIGHTS = ("high_flight", "low_flight")
# share of a normal estimate within two standard errors, and what chance leaves of it
WITHIN_TWO = 0.954
LEAST_CHANCE = 0.001
# mean of 50 standard normal numbers: 3.3 / √50
LARGEST_MEAN = 3.3 / np.sqrt(N_BLOCKS)


def tables():
    """Run the study.

    Returns
    -------
    list of Table
    """
    blocks = of_blocks(study, range(N_BLOCKS))
    rows = [
        _row(source, true, np.array([b[source] for b in blocks]))
        for source, true in SOURCES.items()
    ]
    called = [
        (name.replace("_", " "), f"{factor:.2f} of the true", _share(blocks, name, key))
        for name in FLIGHTS
        for key, factor in (("low", 1.0 / WRONG_BY), ("high", WRONG_BY))
    ]
    right = np.mean([b["right"] for b in blocks])
    called.append(("both", "the true", Figure(right, high=_most_false(), form=".2f")))
    return [
        Table(
            f"Variance components, {N_BLOCKS} blocks of the preset neukirchen",
            "Estimates against the simulated sizes (m for control, µm for m_g). z is "
            "the deviation divided by the standard error of the estimate: its mean "
            f"must be within ±{LARGEST_MEAN:.2f}, and at least {_least_within():.2f} "
            "of the blocks within 2 (the 0.001 quantile if 95.4 % are expected).",
            ("source", "true", "mean estimate", "mean claimed error", "mean z", "in 2"),
            rows,
        ),
        Table(
            "An m_g that was typed wrongly",
            f"Share of {N_BLOCKS} blocks in which the summary reports the m_g of the "
            "flight: all of them if m_g is wrong by a factor of 1.5, none if it is "
            "right (chance allows one).",
            ("flight", "m_g as typed", "reported"),
            called,
        ),
    ]


def study(seed):
    """Estimate the components of one block, and type m_g wrongly.

    Parameters
    ----------
    seed : int

    Returns
    -------
    dict
    """
    block = simulate_block("neukirchen", seed=seed)
    result = densify(block)
    found = {
        source: (component.estimated, component.standard_error)
        for source in SOURCES
        for component in [getattr(result.components, source)]
    }
    found["right"] = wrong_measuring_errors(result.examination) is not None
    for name in FLIGHTS:
        for key, factor in (("low", 1.0 / WRONG_BY), ("high", WRONG_BY)):
            wrong = wrong_measuring_errors(
                densify(typed(block, name, factor)).examination
            )
            found[name, key] = wrong is not None and name in wrong.names
    return found


def typed(block, name, factor):
    """The block with another m_g of one flight.

    Parameters
    ----------
    block : Block
    name : {"high_flight", "low_flight"}
    factor : float

    Returns
    -------
    Block
    """
    flight = getattr(block, name)
    wrong = replace(flight, m_g_um=factor * flight.m_g_um)
    return Block(**{**plain_fields_of(block), name: wrong})


def plain_fields_of(block):
    """Fields of a Block without those that a simulation adds."""
    known = Block.__dataclass_fields__
    return {k: v for k, v in plain_fields(block).items() if k in known}


def _row(source, true, estimates):
    value, error = estimates.T
    z = (value - true) / error
    return (
        source.replace("_", " "),
        f"{true:g}",
        Figure(value.mean(), value.std(ddof=1) / np.sqrt(len(value)), form=".4f"),
        Figure(error.mean(), form=".4f"),
        Figure(z.mean(), low=-LARGEST_MEAN, high=LARGEST_MEAN, form=".2f"),
        Figure(np.mean(np.abs(z) < 2.0), low=_least_within(), form=".2f"),
    )


def _least_within():
    return float(binom.ppf(LEAST_CHANCE, N_BLOCKS, WITHIN_TWO)) / N_BLOCKS


def _most_false():
    return 1.0 / N_BLOCKS


def _share(blocks, name, key):
    return Figure(np.mean([b[name, key] for b in blocks]), low=1.0, form=".2f")
