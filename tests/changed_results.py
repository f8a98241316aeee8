"""Results of solutions that were changed by hand."""

from dataclasses import replace


def changed(result, **tables):
    """The result of a solution with other tables, nothing judged yet.

    Parameters
    ----------
    result : DensificationResult
    tables
        Fields of the solution.
    """
    return replace(result, solution=replace(result.solution, **tables))
