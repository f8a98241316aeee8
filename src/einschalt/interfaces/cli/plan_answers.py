"""An answer of ``einschalt plan``, and the first of three: Kovarik's tables.

Its figures and its tables are made only when they are written; nothing here takes
pandas or numba along.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from einschalt.foundations.errors import EinschaltError
from einschalt.interfaces.cli.plan_heights import heights_of_tables, said_of
from einschalt.interfaces.cli.plan_values import Asked
from einschalt.pipeline.planning.estimate.text import describe_table
from einschalt.pipeline.planning.tables.precision_table import (
    best_columns,
    break_even_columns,
    frame_of,
    precision_table,
)


@dataclass(frozen=True, eq=False)
class Answer:
    """A text, and how to make the rest of it.

    ``tables`` gives DataFrames and ``figures`` Figures by name; the first is the one
    that a single file holds.
    """

    text: str
    tables: Callable
    figures: Callable
    scale_numbers: Sequence[float]  # in question, for the terrain
    # what programs are told, a dict; the rows of the first table where left out
    headline: Callable | None = None
    # writes further files into the folder of the answer
    files: Callable | None = None
    # gives the planned block and the frame of its search, for plan.json
    planned: Callable | None = None
    # why no plan is recommended; the search is then done, and its question is not
    problem: EinschaltError | None = None
    # what programs are told beside that: it has to be known, and forbids nothing
    notes: Sequence[EinschaltError] = ()


def tables(asked: Asked) -> Answer:
    """Answer with the tables of Kovarik's diagrams."""
    flight = asked.flight
    preset = flight.preset
    axes = {
        "scale_number": asked.numbers("scale_number", preset.scale_numbers),
        "spacing": asked.numbers("spacing", preset.spacings),
        "m_0": asked.numbers("m_0", preset.m_0),
        "m_g_um": asked.numbers("m_g_um", preset.m_g_um),
    }
    table = precision_table(axes, flight.model, flight.principal_distance)
    best = best_columns(axes, flight.model, flight.principal_distance)

    def figures():
        # imported when figures are drawn: matplotlib takes its time
        from einschalt.interfaces.reports import planning_figures  # noqa: PLC0415

        return {"diagrams": planning_figures.diagrams_figure(table)}

    def frames():
        return {
            "plan": frame_of(table.columns()),
            "best_scales": frame_of(best),
            "break_even": frame_of(break_even_columns(table)),
        }

    scales = table.axes["scale_number"]
    heights = heights_of_tables(asked, scales)
    warnings = (*map(said_of, heights.problems), *table.warnings)
    text = describe_table(replace(table, warnings=warnings), best, heights.lines)
    return Answer(text, frames, figures, scales, notes=heights.problems)
