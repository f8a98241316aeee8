"""The Python interface to simulated blocks, which can also be written."""

import os
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import pandas as pd

from einschalt.foundations.arguments import as_path
from einschalt.interfaces.python_api import Block
from einschalt.pipeline.block.block import plain_fields
from einschalt.pipeline.simulation import simulate_block as simulated
from einschalt.pipeline.simulation.geometry import BlockGeometry
from einschalt.pipeline.simulation.noise import BlockNoise

if TYPE_CHECKING:
    from einschalt.pipeline.planning.area.recommended import AreaPlan
    from einschalt.pipeline.planning.choice.check import CheckedPlan
    from einschalt.pipeline.planning.estimate.search import PlanFrame
    from einschalt.pipeline.planning.flights.flight_design import FlightDesign
    from einschalt.pipeline.planning.propagation.expected_precision import (
        ExpectedPrecision,
    )


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class SimulatedBlock(simulated.SimulatedBlock, Block):
    """A block with known ``truth``, which can be written as a folder."""


def simulate_block(
    preset: str = "neukirchen",
    *,
    seed: int = 0,
    geometry: BlockGeometry | None = None,
    noise: BlockNoise | None = None,
    title: str | None = None,
) -> SimulatedBlock:
    """Simulate a block with known truth.

    Parameters
    ----------
    preset : {"neukirchen", "demo"}
        Kovarik's test block, 10.4 x 10.2 km with 1190 points and two coverages at
        1:15 000 and at 1:8000; or a small block of 3 x 3 km with 6 check points.
    seed : int
        The same seed gives the same block.
    geometry : BlockGeometry, optional
        Instead of the preset's.
    noise : BlockNoise, optional
        Instead of the preset's.
    title : str, optional
        Name of the block; that of the preset, or scales and spacing of another
        geometry, where left out.

    Returns
    -------
    SimulatedBlock
        Every table as it would be read from files, and ``truth``: point_id, easting,
        northing [, height].

    Raises
    ------
    SettingsError
        The preset is unknown, the seed is not a whole number from 0, or no model of a
        flight would hold enough points.
    """
    given = {"geometry": geometry, "noise": noise, "title": title}
    block = simulated.simulate_block(preset, seed=seed, **given)
    return SimulatedBlock(**plain_fields(block))


def simulate_plan(
    plan: (
        "FlightDesign | ExpectedPrecision | CheckedPlan | AreaPlan | pd.Series[Any] "
        "| str | os.PathLike[str]"
    ),
    *,
    frame: "PlanFrame | None" = None,
    seed: int = 0,
    noise: BlockNoise | None = None,
    measurement: Literal["machine", "parallaxes", "images"] = "machine",
    transformation: Literal["affine", "helmert", "rigid", "helmert_3d"] | None = None,
    n_check: int = 0,
    title: str | None = None,
) -> SimulatedBlock:
    """Simulate the block that a plan would give, to try it.

    Photographs, models, control and errors are those of the plan, over its area and on
    its ground, with points as close as planned. What :func:`densify` computes from it
    is comparable with what the plan expects.

    Parameters
    ----------
    plan : FlightDesign, ExpectedPrecision, CheckedPlan, AreaPlan, Series, str or path
        A design, what :func:`expect_precision`, :func:`plan_target` or
        :func:`plan_area` gives, a row of ``plans`` of :func:`find_plans`, or the folder
        that ``einschalt plan --output`` wrote.
    frame : PlanFrame, optional
        That of the search, with a row of it.
    seed : int
        Of the errors: the same seed gives the same block, another one the same points,
        models and control with other errors.
    noise : BlockNoise, optional
        Instead of the errors of the plan: larger ones, or gross errors.
    measurement : {"machine", "parallaxes", "images"}
        What the tables hold, as in :class:`BlockGeometry`.
    transformation : {"affine", "helmert", "rigid", "helmert_3d"}, optional
        How the models are fitted; as planned where left out.
    n_check : int
        How many new points have given coordinates too, in the role ``check``.
    title : str, optional
        Name of the block; camera, scales and spacing where left out.

    Returns
    -------
    SimulatedBlock
        With ``truth``: point_id, easting, northing [, height].

    Raises
    ------
    EinschaltError
        It is no plan, its folder cannot be read, or a value is not sensible.

    Examples
    --------
    >>> import einschalt as es
    >>> design = es.FlightDesign(scale_number=8000, spacing=300, m_g_um=5)
    >>> expected = es.expect_precision(design)
    >>> result = es.densify(es.simulate_plan(expected, seed=1))
    >>> bool(abs(result.figures.mean_total / expected.figures.mean - 1.0) < 0.05)
    True
    """
    # imported when a plan is tried: propagation and areas take their time
    from einschalt.interfaces.files.plan_file import read_plan_file  # noqa: PLC0415
    from einschalt.pipeline.planning.area import simulated_plan  # noqa: PLC0415

    if isinstance(plan, (str, os.PathLike)):
        plan = read_plan_file(as_path("plan", plan))
    changes = {"measurement": measurement, "n_check": n_check}
    if transformation is not None:
        changes["transformation"] = transformation
    given = {"frame": frame, "seed": seed, "noise": noise, "title": title}
    block = simulated_plan.simulate_plan(plan, **given, **changes)
    return SimulatedBlock(**plain_fields(block))
