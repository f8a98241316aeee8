"""Dangerous surfaces of a planned flight at several scales."""

import pandas as pd
import pytest

from einschalt.pipeline.planning.flights.arguments import planned_model
from einschalt.pipeline.planning.flights.cameras import CAMERAS
from einschalt.pipeline.planning.tables.terrain import (
    describe_forecast,
    forecast_by_camera,
    forecast_by_scale,
)
from einschalt.stages.relative_orientation.dangerous_surface import (
    FlightPlan,
    forecast_dangerous_surfaces,
)

FILM = planned_model("affine", "kovarik", 0.23, 0.6, 0.3)
COLUMNS = ["model_id", "h1", "h2", "h3", "h4", "h5", "h6"]
VALLEY = pd.DataFrame(
    [
        ["7/8", 600, 600, 900, 900, 900, 900],
        ["8/9", 600, 610, 620, 600, 590, 605],
    ],
    columns=COLUMNS,
)


def test_each_scale_is_the_forecast_of_its_own():
    forecast = forecast_by_scale(VALLEY, [6000, 9000], FILM, 0.152)
    assert len(forecast) == 4
    for scale_number, models in forecast.groupby("scale_number"):
        plan = FlightPlan(principal_distance=0.152, scale_number=scale_number)
        own = forecast_dangerous_surfaces(VALLEY, plan).models
        for name in ("verdict", "inflation", "over_correction_k"):
            assert models[name].tolist() == pytest.approx(own[name].tolist())


def test_an_oblong_image_has_its_own_base_and_wings():
    camera = CAMERAS["dmc_3"]
    model = planned_model("affine", "kovarik", camera.image_format, 0.6, 0.3)
    forecast = forecast_by_scale(VALLEY, [10_000], model, 0.092)
    along, across = camera.image_format
    # the depth of a dangerous valley: Waldhäusl's w²/(w² + c²) of the flying height
    wing = across / 2 - 0.015
    depth = forecast["critical_depth"] / forecast["flying_height"]
    assert depth.iloc[0] == pytest.approx(wing**2 / (wing**2 + 0.092**2), rel=1e-9)
    assert along < across


def test_a_dangerous_valley_is_said_with_the_remedy():
    forecast = forecast_by_scale(VALLEY, [6000, 20000], FILM, 0.152)
    text = describe_forecast(forecast, forecast_by_camera(VALLEY, 912.0))
    assert "1 critical, 1 safe" in text
    assert "1:6000: model 7/8 is critical; fly" in text
    assert "above its valley" in text
    assert "over-correction k" in text


def test_terrain_above_the_cameras_is_said_to_be():
    """It was told as a valley whose flying height is too low for its depth."""
    ground = VALLEY.assign(h3=[1600, 620], h4=[1600, 600])
    forecast = forecast_by_scale(ground, [6000, 20000], FILM, 0.152)
    text = describe_forecast(forecast, forecast_by_camera(ground, 912.0))
    said = " ".join(text.split())
    assert (
        "1:6000: the terrain of model 7/8 reaches the flying height in a standard "
        "point; fly higher." in said
    )
    assert "1:20 000: the terrain" not in said


def test_many_scales_are_cut():
    forecast = forecast_by_scale(VALLEY, range(6000, 16000, 1000), FILM, 0.152)
    assert "and 2 scales more" in describe_forecast(
        forecast, forecast_by_camera(VALLEY, 912.0)
    )


def test_every_camera_flies_at_the_same_height():
    forecast = forecast_by_camera(VALLEY, 900.0)
    assert forecast["flying_height"].to_numpy() == pytest.approx(900.0)
    wide = forecast[forecast["camera"] == "film_wide"]
    own = forecast_by_scale(VALLEY, [900.0 / 0.152], FILM, 0.152)
    for name in ("scale_number", "inflation", "over_correction_k", "valley_depth"):
        assert wide[name].to_numpy() == pytest.approx(own[name].to_numpy(), rel=1e-12)
    # the wider the angle, the deeper the dangerous valley, and the lower the flight
    # that is safe above it: Waldhäusl 1971
    safe = forecast[forecast["model_id"] == "7/8"].set_index("camera")
    heights = safe["safe_flying_height"]
    assert heights["film_super_wide"] < heights["film_wide"] < heights["film_normal"]
