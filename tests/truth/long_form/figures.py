"""Figures from many blocks, with their Monte Carlo errors, judged and typeset."""

import os
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass

import numpy as np

# a figure that is not known to 0.01 cannot be judged
LARGEST_ERROR = 0.01
N_PROCESSES = 2


@dataclass(frozen=True)
class Figure:
    """One figure of a table.

    Attributes
    ----------
    value, error : float
        And its Monte Carlo standard error.
    low, high : float
        Bounds; infinite where the figure is printed for comparison only.
    form : str
        How it is typeset.
    known_to : float
        Largest error of a figure that is judged.
    """

    value: float
    error: float = 0.0
    low: float = -np.inf
    high: float = np.inf
    form: str = ".3f"
    known_to: float = LARGEST_ERROR

    @property
    def is_judged(self):
        """Whether it has bounds."""
        return np.isfinite(self.low) or np.isfinite(self.high)

    @property
    def passes(self):
        """Whether it lies within its bounds, and is known well enough to say so."""
        if not self.is_judged:
            return True
        return self.low <= self.value <= self.high and self.error <= self.known_to

    def __str__(self):
        error = f" ± {self.error:{self.form}}" if self.error else ""
        return f"{self.value:{self.form}}{error}{'' if self.passes else ' **out**'}"


@dataclass(frozen=True)
class Table:
    """A table of figures with what it shows.

    Attributes
    ----------
    title : str
    text : str
        What was done, and which bounds hold.
    head : tuple of str
    rows : list of tuple
        Of str and Figure.
    """

    title: str
    text: str
    head: tuple
    rows: list

    @property
    def passes(self):
        """Whether no figure is out of its bounds."""
        return all(c.passes for row in self.rows for c in row if isinstance(c, Figure))

    def markdown(self):
        """Typeset as a section of a page."""
        lines = [f"## {self.title}", "", self.text, ""]
        lines.append(f"| {' | '.join(self.head)} |")
        lines.append(f"|{'---|' * len(self.head)}")
        lines += [f"| {' | '.join(str(c) for c in row)} |" for row in self.rows]
        return "\n".join(lines)


def ratio(numerators, denominators, **bounds):
    """Ratio of two sums over blocks, its error from the scatter between them.

    Parameters
    ----------
    numerators, denominators : array of float, shape (n_blocks,)
    **bounds
        Of the Figure.

    Returns
    -------
    Figure
    """
    n, d = np.asarray(numerators, float), np.asarray(denominators, float)
    value = n.sum() / d.sum()
    scatter = np.sqrt(np.sum((n - value * d) ** 2) * len(n) / (len(n) - 1))
    return Figure(float(value), float(scatter / d.sum()), **bounds)


def root_of_ratio(numerators, denominators, **bounds):
    """Square root of :func:`ratio`."""
    squared = ratio(numerators, denominators)
    root = np.sqrt(squared.value)
    return Figure(float(root), float(squared.error / (2.0 * root)), **bounds)


def of_blocks(study, seeds):
    """Run a study of one block for many seeds, in a few processes.

    Parameters
    ----------
    study : callable
        From a seed to anything that can be sent between processes.
    seeds : iterable of int

    Returns
    -------
    list
        In the order of the seeds.
    """
    # threads of a kernel within each process would only wait for each other
    os.environ["OMP_NUM_THREADS"] = "1"
    with ProcessPoolExecutor(N_PROCESSES) as pool:
        return list(pool.map(study, seeds, chunksize=2))
