"""Dangerous surfaces of a planned flight, for each image scale in question."""

import pandas as pd

from einschalt.foundations import typesetting
from einschalt.foundations.typesetting import fixed, number, scale, wrapped
from einschalt.stages.relative_orientation.dangerous_surface import (
    EDGE,
    FlightPlan,
    count_verdicts,
    forecast_dangerous_surfaces,
)

MOST_SCALES = 8
HEAD = (
    "Dangerous surfaces: inflation of omega's error and over-correction k of the\n"
    "worst model, heights above the middle of its valley [m]"
)


def forecast_by_scale(heights, scale_numbers, model, principal_distance):
    """Judge the terrain of every model at several image scales.

    Parameters
    ----------
    heights : DataFrame
        model_id, h1 … h6: heights of the terrain in the standard points [m].
    scale_numbers : sequence of float
    model : PlannedModel
    principal_distance : float
        [m]

    Returns
    -------
    DataFrame
        scale_number, model_id, then what ``forecast_dangerous_surfaces`` says: verdict,
        over_correction_k, over_correction_n, inflation, safe_flying_height and more.

    Raises
    ------
    EinschaltError
        A height is missing or no number.
    """
    along, across = model.image_format
    # the forecast knows square images: of an oblong one the side across is given,
    # which holds the wings, with the overlap that leaves the base as long as it is
    overlap = 1.0 - (1.0 - model.forward_overlap) * along / across
    wing = max(across / 2.0 - EDGE, across / 4.0)
    parts = {}
    for scale_number in scale_numbers:
        plan = FlightPlan(
            principal_distance=principal_distance,
            scale_number=float(scale_number),
            image_format=across,
            forward_overlap=overlap,
            wing=wing,
        )
        parts[float(scale_number)] = forecast_dangerous_surfaces(heights, plan).models
    return pd.concat(parts, names=["scale_number"]).reset_index()


def describe_forecast(forecast):
    """Say at which scales the terrain is dangerous, and what helps.

    Parameters
    ----------
    forecast : DataFrame
        As :func:`forecast_by_scale` gives it.

    Returns
    -------
    str
    """
    rows, said = [], []
    groups = list(forecast.groupby("scale_number"))
    for scale_number, models in groups[:MOST_SCALES]:
        worst = models.loc[models["inflation"].fillna(float("inf")).idxmax()]
        rows.append(
            [
                scale(scale_number),
                count_verdicts(models).split(": ")[1],
                fixed(worst["inflation"], 2),
                str(worst["model_id"]),
                fixed(worst["over_correction_k"], 2),
                fixed(worst["flying_height"], 0),
                fixed(worst["safe_flying_height"], 0),
            ]
        )
        if worst["verdict"] != "safe":
            said.append(_advice(scale_number, worst))
    header = ["scale", "models", "inflation", "worst", "k", "height", "safe from"]
    text = typesetting.table(rows, header=header, align="llrlrrr")
    more = len(groups) - MOST_SCALES
    return "\n".join(
        [
            HEAD,
            text,
            *([f"  and {more} scales more"] if more > 0 else []),
            *said,
        ]
    )


def _advice(scale_number, worst):
    text = f"{scale(scale_number)}: model {worst['model_id']} is {worst['verdict']}"
    if worst["safe_flying_height"] > worst["flying_height"]:
        height = number(worst["safe_flying_height"])
        text += f"; fly {height} m above its valley, or with a wider angle"
    return wrapped(f"{text}.", first="  ", indent="    ")
