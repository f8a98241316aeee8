"""Results of solutions that were changed by hand."""

from contextlib import nullcontext
from dataclasses import replace

from einschalt.pipeline.result import Stopwatch


class Stopped(Stopwatch):
    """A time that stays as it is."""

    def running(self):
        """Count nothing."""
        return nullcontext()


def changed(result, **tables):
    """The result of a solution with other tables, nothing judged yet.

    Parameters
    ----------
    result : DensificationResult
    tables
        Fields of the solution.
    """
    return replace(result, solution=replace(result.solution, **tables))


def judged_before(result, **tables):
    """The same, judged as the result was: for what shows tables, however they are.

    Parameters
    ----------
    result : DensificationResult
    tables
        Fields of the solution.
    """
    other = changed(result, **tables)
    vars(other)["assessment"] = result.assessment  # as a cached property keeps it
    return other


def from_elsewhere(result, block):
    """The same, as if its block had been read from another place.

    Parameters
    ----------
    result : DensificationResult
    block : Block
        With the tables of the result's own.
    """
    other = judged_before(result, block=block)
    # its points are judged, and tables of its precision computed, as they were
    vars(other)["examination"] = result.examination
    return other
