"""Whether what makes a stereo model belongs together: photographs, parallaxes, base."""

import numpy as np
import pandas as pd

from einschalt.foundations import tables
from einschalt.foundations.errors import ConsistencyError
from einschalt.foundations.key_columns import row_codes, rows_among
from einschalt.foundations.names import is_among
from einschalt.stages.stage2_relative_orientation import LOOK_AT_PHOTOGRAPHS

BASE_OF_EXTENT = (0.02, 50.0)
LARGEST_PARALLAX_OF_BASE = 0.2
MODEL_KEY = ("coverage", "model_id")


def points_in_both_photographs(models, image_points) -> pd.DataFrame:
    """Points that both photographs of a model show: coverage, model_id, point_id."""
    left = models.merge(image_points, left_on="left_image", right_on="image_id")
    both = left.merge(
        image_points,
        left_on=["right_image", "point_id"],
        right_on=["image_id", "point_id"],
    )
    return both[["coverage", "model_id", "point_id"]]


def images_without_points(flight, models_file, points_file):
    """Photographs of the models that were not measured."""
    models, measured = flight.models, flight.image_points["image_id"].unique()
    found = []
    for side in ("left_image", "right_image"):

        def problem(place, side=side):
            return ConsistencyError(
                f"{side} '{models[side].iloc[place]}' has no image points",
                expected=f"an image_id of {points_file}",
                remedy="Correct the name, or delete the model",
                file=models_file,
                **tables.row_location(models, place),
            )

        places = np.flatnonzero(~is_among(models[side], measured))
        found += tables.listed(places, problem, f"{side} is unknown")
    return found


def models_without_parallaxes(flight, points_file, parallaxes_file):
    """Models that are to be oriented, without measured parallaxes."""
    keys = [key for key in MODEL_KEY if key in flight.y_parallaxes]
    frame = flight.model_points
    both = pd.concat([frame[keys], flight.y_parallaxes[keys]], ignore_index=True)
    codes = row_codes([both[key] for key in keys])
    model, oriented = codes[: len(frame)], codes[len(frame) :]
    is_first = ~pd.Series(model).duplicated().to_numpy()
    return [
        ConsistencyError(
            "the model has no y-parallaxes",
            expected=f"a model of {parallaxes_file}",
            remedy="Correct its name, measure them, or delete the model",
            file=points_file,
            **tables.row_location(frame, place),
        )
        for place in np.flatnonzero(is_first & ~np.isin(model, oriented))
    ]


def parallax_problems(flight, files):
    """Bases and parallaxes that cannot have the unit of the models."""
    bases = flight.base["base"] if hasattr(flight.base, "columns") else [flight.base]
    base = float(np.median(np.asarray(bases, dtype=float)))
    parallaxes = flight.y_parallaxes
    keys = [key for key in ("coverage", "model_id") if key in parallaxes]
    y = parallaxes.groupby(keys)["y"]
    extent = float((y.max() - y.min()).median())
    largest = float(parallaxes["y_parallax"].abs().median())
    low, high = BASE_OF_EXTENT
    problems = []
    if extent > 0.0 and not low * extent <= base <= high * extent:
        problems.append(
            ConsistencyError(
                f"base {base:g}, where the parallaxes extend over {extent:g} in y",
                expected=f"{low * extent:.3g} to {high * extent:.3g}, in the same unit",
                remedy="Give the base in model_unit",
                file=files["base"],
            )
        )
    elif largest > LARGEST_PARALLAX_OF_BASE * base:
        problems.append(
            ConsistencyError(
                f"y_parallax {largest:g} (median), where the base is {base:g}",
                expected=f"less than {LARGEST_PARALLAX_OF_BASE * base:.3g}",
                remedy="Give the parallaxes in model_unit",
                file=files["y_parallaxes"],
            )
        )
    return problems


def models_of_photographs_apart(flight, model_table, file) -> list[ConsistencyError]:
    """List the models whose photographs have no point in common.

    Parameters
    ----------
    flight : Flight
        With images.
    model_table : DataFrame
        coverage, model_id of each point that was measured in both photographs.
    file : str
        Of the models.
    """
    models = flight.models

    def problem(place):
        left, right = models[["left_image", "right_image"]].iloc[place]
        return ConsistencyError(
            f"photographs '{left}' and '{right}' have no point in common",
            expected="points that were measured in both",
            remedy=LOOK_AT_PHOTOGRAPHS,
            file=file,
            **tables.row_location(models, place),
        )

    is_lost = ~rows_among(models, model_table, list(MODEL_KEY))
    return [problem(place) for place in np.flatnonzero(is_lost)]


def models_of_one_photograph(flight, file) -> list[ConsistencyError]:
    """List the models whose photographs are the same one.

    Parameters
    ----------
    flight : Flight
        With images.
    file : str
        Of the models.
    """
    models = flight.models

    def problem(place):
        return ConsistencyError(
            f"left_image and right_image are both '{models['left_image'].iloc[place]}'",
            expected="two photographs",
            remedy="Correct one of the names, or delete the model",
            file=file,
            **tables.row_location(models, place),
        )

    is_same = (models["left_image"] == models["right_image"]).to_numpy(dtype=bool)
    return [problem(place) for place in np.flatnonzero(is_same)]
