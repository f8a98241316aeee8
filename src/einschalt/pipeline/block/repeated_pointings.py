"""Points that were set several times: the means of their settings.

A table with a column ``setting`` has a row for each setting. The block has one row for
each point: the mean, how many settings it is from (``n_settings``), and how far one of
them lies from it (``settings_spread``). Means have m_g / √k, whatever their settings
say; what these say of m_g itself is judged in ``assessment/repeated_settings``.
"""

import numpy as np
import pandas as pd

from einschalt.foundations import tables
from einschalt.foundations.batches import segments
from einschalt.foundations.errors import TableError
from einschalt.foundations.frame_columns import values_of
from einschalt.foundations.key_columns import row_codes
from einschalt.theory.measuring_error import mean_of_settings

SPREAD = "settings_spread"


def settings_problems(model_points, file):
    """Say what is wrong with the settings of a flight's points."""
    problems = []
    twice = [n for n in ("n_settings", SPREAD) if n in model_points]
    if tables.SETTING in model_points and twice:
        problems.append(
            TableError(
                f"column '{twice[0]}' stands beside '{tables.SETTING}'",
                expected="a row for each setting, or means of several",
                remedy="Delete one of the two columns",
                file=file,
            )
        )
    if SPREAD not in model_points:
        return problems
    places = np.flatnonzero(model_points[SPREAD].to_numpy() < 0.0)

    def problem(place):
        return TableError(
            f"{SPREAD} '{model_points[SPREAD].iloc[place]:g}' is negative",
            expected="0 or more",
            remedy="Give the standard deviation of one setting, x and y together",
            file=file,
            **tables.row_location(model_points, place),
        )

    return problems + tables.listed(places, problem, f"{SPREAD} is negative")


def average_settings(model_points):
    """Take the mean of the settings of each point, where rows are settings.

    A row for each point, with n_settings and settings_spread (total, in the unit of the
    coordinates; NaN where a point was set once), in the order of their first settings.
    """
    if tables.SETTING not in model_points:
        return model_points
    keys = [name for name in tables.MODEL_POINTS.key if name in model_points]
    codes = pd.factorize(row_codes([model_points[name] for name in keys]))[0]
    sort = segments(codes, int(codes.max()) + 1)
    axes = [axis for axis in "xyz" if axis in model_points]
    values = values_of(model_points, axes)[sort.order]
    mean, spread = mean_of_settings(values, sort.start)
    points = model_points.iloc[sort.order[sort.start[:-1]]]
    return points.drop(columns=tables.SETTING).assign(
        **dict(zip(axes, mean.T, strict=True)),
        n_settings=sort.count.astype(float),
        **{SPREAD: spread},
    )
