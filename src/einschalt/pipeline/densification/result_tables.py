"""Tables of a result, joined from those of its stages and flights."""

import numpy as np
import pandas as pd

from einschalt.foundations.frame_columns import columns_of, with_columns
from einschalt.foundations.names import is_among
from einschalt.stages.results import FAILURE_COLUMNS

LOW = "low_flight"
HIGH = "high_flight"
PLAN_AXES = 2


def with_roles(points, control_points, without_part=()):
    """Say which points are new, control or check, and by how much these are missed.

    Control onto which nothing could be fitted, names of ``without_part``, is check.

    With ``role`` before ``is_suspect``, and difference_easting, difference_northing
    [, difference_height] (densified minus given) [m].
    """
    names = [n for n in ("easting", "northing", "height") if n in points]
    differences = [f"difference_{name}" for name in names]
    if control_points is None:
        points.insert(points.columns.get_loc("is_suspect"), "role", "new")
        return points.assign(**dict.fromkeys(differences, np.nan))
    given = control_points.set_index("point_id").reindex(points["point_id"])
    role = given["role"].fillna("new").to_numpy(dtype=object)
    role = np.where(is_among(points["point_id"], without_part), "check", role)
    points.insert(points.columns.get_loc("is_suspect"), "role", role)
    for name, difference in zip(names, differences, strict=True):
        known = given[name].to_numpy() if name in given else np.nan
        points[difference] = points[name] - known
    return points


def with_standard_errors(points, errors):
    """Write the propagated errors, if any, before those of the paper."""
    if errors is None:
        return points
    covariance = errors.covariance
    place = points.columns.get_loc("standard_error_paper")
    east, north = covariance[:, 0, 0], covariance[:, 1, 1]
    columns = {
        "standard_error_easting": np.sqrt(east),
        "standard_error_northing": np.sqrt(north),
        "covariance_en": covariance[:, 0, 1],
        "standard_error_total": np.sqrt(east + north),
    }
    if covariance.shape[1] > PLAN_AXES:
        columns["standard_error_height"] = np.sqrt(covariance[:, 2, 2])
    before, after = points.iloc[:, :place], points.iloc[:, place:]
    return pd.concat([before, pd.DataFrame(columns), after], axis=1)


def of_oriented_flights(flights, table):
    """Orientations or residuals (``table``) of all flights together."""
    of_flights = {name: getattr(oriented, table) for name, oriented in flights.items()}
    parts = [part.assign(flight=name) for name, part in of_flights.items() if len(part)]
    if not parts:
        empty = next(iter(of_flights.values()))
        return pd.DataFrame(columns=["flight", *empty.columns])
    return _flight_first(pd.concat(parts, ignore_index=True))


def of_orientations(flights):
    """What every solution keeps of stage 2, by the names of its fields."""
    return {
        "orientations": of_oriented_flights(flights, "orientations"),
        "orientation_residuals": of_oriented_flights(flights, "residuals"),
        "orientation_errors": {name: o.errors for name, o in flights.items()},
    }


def of_transformed_flights(high, low, table_of):
    """A table of stage 3 of both flights, which ``table_of`` takes of each."""
    parts = [with_columns(table_of(low), flight=LOW)]
    if high is not None:
        parts.insert(0, with_columns(table_of(high.transformation), flight=HIGH))
    return _flight_first(pd.concat(parts, ignore_index=True))


def models_with_parameters(fit):
    """Models of a transformation beside their parameters, a DataFrame."""
    return pd.concat([fit.models, fit.parameters.reset_index(drop=True)], axis=1)


def failures_of(parts):
    """One table of failures from pairs: a flight, and those of one of its stages."""
    filled = [
        table.assign(flight=flight) if flight else table
        for flight, table in parts
        if len(table)
    ]
    columns = ["flight", *FAILURE_COLUMNS]
    if not filled:
        return pd.DataFrame(columns=columns)
    return pd.concat(filled, ignore_index=True)[columns]


def _flight_first(table):
    return columns_of(table, ["flight", *(name for name in table if name != "flight")])
