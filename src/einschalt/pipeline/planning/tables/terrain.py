"""Dangerous surfaces of a planned flight, for each image scale in question."""

import pandas as pd

from einschalt.foundations import typesetting
from einschalt.foundations.display_names import shortened
from einschalt.foundations.language import mark, translated
from einschalt.foundations.typesetting import at_least, fixed, number, scale, wrapped
from einschalt.pipeline.planning.flights.cameras import CAMERAS
from einschalt.stages.relative_orientation.dangerous_surface import (
    EDGE,
    REACHED,
    VERDICTS,
    FlightPlan,
    amounts_of_verdicts,
    forecast_dangerous_surfaces,
)

MOST_SCALES = 8
HEAD = mark(
    "Dangerous surfaces: inflation of omega's error and over-correction k of the\n"
    "worst model, heights above the middle of its valley [m]"
)


def forecast_by_scale(heights, scale_numbers, model, principal_distance):
    """Judge the terrain of every model at several image scales.

    ``heights``: model_id, h1 … h6, of the terrain in the standard points [m]. Gives
    scale_number, model_id, then what ``forecast_dangerous_surfaces`` says: verdict,
    over_correction_k, over_correction_n, inflation, safe_flying_height and more.
    """
    parts = {}
    for scale_number in map(float, scale_numbers):
        plan = _plan_of(model, principal_distance, scale_number * principal_distance)
        parts[scale_number] = forecast_dangerous_surfaces(heights, plan).models
    return pd.concat(parts, names=["scale_number"]).reset_index()


def forecast_by_camera(heights, flying_height) -> pd.DataFrame:
    """Judge the terrain of every model for each of ``CAMERAS``, flown equally high.

    ``flying_height`` is that above the standard points 1 and 2 of each model [m]. Gives
    camera, scale_number, model_id, then as :func:`forecast_by_scale`.
    """
    parts = {}
    for name, camera in CAMERAS.items():
        plan = _plan_of(camera, camera.principal_distance, flying_height)
        models = forecast_dangerous_surfaces(heights, plan).models
        models.insert(0, "scale_number", flying_height / camera.principal_distance)
        parts[name] = models
    return pd.concat(parts, names=["camera"]).reset_index()


def _plan_of(camera, principal_distance, flying_height):
    along, across = camera.image_format
    # the forecast knows square images: of an oblong one the side across is given,
    # which holds the wings, with the overlap that leaves the base as long as it is
    overlap = 1.0 - (1.0 - camera.forward_overlap) * along / across
    return FlightPlan(
        principal_distance=principal_distance,
        flying_height=flying_height,
        image_format=across,
        forward_overlap=overlap,
        wing=max(across / 2.0 - EDGE, across / 4.0),
    )


def describe_forecast(forecast, by_camera) -> str:
    """Say at which scales and for which cameras the terrain is dangerous."""
    groups = list(forecast.groupby("scale_number"))[:MOST_SCALES]
    more = forecast["scale_number"].nunique() - MOST_SCALES
    worst = [(scale_number, _worst(models)) for scale_number, models in groups]
    height = by_camera["flying_height"].iloc[0]
    return "\n".join(
        [
            translated(HEAD),
            _table(
                [_row([scale(key)], models) for key, models in groups],
                [translated("scale")],
            ),
            *([translated("  and {n} scales more", n=more)] if more > 0 else []),
            *(_advice(*found) for found in worst if found[1]["verdict"] != "safe"),
            "",
            translated(
                "The same terrain with every camera, flown {height} m high",
                height=number(height, 3),
            ),
            _table(
                [
                    _row([name, scale(models["scale_number"].iloc[0])], models)
                    for name, models in by_camera.groupby("camera", sort=False)
                ],
                [translated("camera"), translated("scale")],
            ),
        ]
    )


def _worst(models):
    return models.loc[models["inflation"].fillna(float("inf")).idxmax()]


def _row(first, models):
    worst = _worst(models)
    return [
        *first,
        amounts_of_verdicts(models),
        fixed(worst["inflation"], 2),
        shortened(str(worst["model_id"]), 16),
        fixed(worst["over_correction_k"], 2),
        fixed(worst["flying_height"], 0),
        fixed(worst["safe_flying_height"], 0),
    ]


def _table(rows, first):
    header = [
        *first,
        translated("models"),
        translated("inflation"),
        translated("worst"),
        "k",
        translated("height"),
        translated("safe from"),
    ]
    align = "l" * len(first) + "lrlrrr"
    return typesetting.table(rows, header=header, align=align)


def _advice(scale_number, worst):
    message = mark("{scale}: model {model} is {verdict}.")
    if worst["reason"] == REACHED:  # then there is no inflation to tell
        message = mark(
            "{scale}: the terrain of model {model} reaches the flying height in a "
            "standard point; fly higher."
        )
    elif worst["safe_flying_height"] > worst["flying_height"]:
        message = mark(
            "{scale}: model {model} is {verdict}; fly {height} m above its valley, or "
            "with a wider angle."
        )
    text = translated(
        message,
        scale=scale(scale_number),
        model=worst["model_id"],
        verdict=translated(VERDICTS[worst["verdict"]]),
        height=at_least(worst["safe_flying_height"]),
    )
    return wrapped(text, first="  ", indent="    ")
