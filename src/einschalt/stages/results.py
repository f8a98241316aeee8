"""What the results of all stages have in common."""

import numpy as np
import pandas as pd

from einschalt.foundations.errors import TableError, name_some

FAILURE_COLUMNS = ["coverage", "model_id", "stage", "reason", "remedy"]


class Result:
    """A frozen result: ``print`` shows its summary."""

    def summary(self):
        """Return the result as text."""
        raise NotImplementedError

    def __str__(self):
        """Return the summary."""
        return self.summary()

    __repr__ = __str__


def failures_table(rows):
    """Failed models as a table.

    Parameters
    ----------
    rows : iterable of tuple
        coverage, model_id, stage, reason, remedy.

    Returns
    -------
    DataFrame
    """
    return pd.DataFrame(list(rows), columns=FAILURE_COLUMNS).astype(object)


def row_of_model(models, model_id, coverage=None):
    """Position of a model in a table of models.

    Parameters
    ----------
    models : DataFrame
        With the columns coverage and model_id.
    model_id : str
    coverage : str, optional
        Needed where two coverages have a model of that name.

    Returns
    -------
    int

    Raises
    ------
    TableError
        There is no such model, or there is one in each of several coverages.
    """
    is_it = (models["model_id"] == str(model_id)).to_numpy()
    if coverage is not None:
        is_it = is_it & (models["coverage"] == str(coverage)).to_numpy()
    places = np.flatnonzero(is_it)
    if len(places) == 1:
        return int(places[0])
    if len(places) == 0:
        raise TableError(
            "there is no such model",
            expected=f"one of {name_some(models['model_id'])}",
            model=model_id,
        )
    raise TableError(
        f"coverages {name_some(models['coverage'].iloc[places])} each have this model",
        remedy="Name the coverage as well",
        model=model_id,
    )
