"""Dangerous surfaces of a terrain, added to an answer of ``einschalt plan``."""

from dataclasses import replace

from einschalt.foundations.errors import raise_problems
from einschalt.foundations.tables import check_table
from einschalt.interfaces.cli.plan_answers import Answer
from einschalt.interfaces.cli.plan_values import Asked
from einschalt.interfaces.files.tables_by_suffix import read_table
from einschalt.pipeline.planning.tables import terrain as terrain_forecast
from einschalt.stages.relative_orientation.dangerous_surface import TERRAIN_HEIGHTS


def with_terrain(given, file, asked: Asked) -> Answer:
    """Add the dangerous surfaces of a terrain (model_id, h1 … h6 [m]) to an answer."""
    raw = read_table(file, TERRAIN_HEIGHTS)
    checked = check_table(raw, TERRAIN_HEIGHTS, source=file.name)
    raise_problems(checked.problems)
    flight = asked.flight
    forecast = terrain_forecast.forecast_by_scale(
        checked.frame, given.scale_numbers, flight.model, flight.principal_distance
    )
    by_camera = terrain_forecast.forecast_by_camera(
        checked.frame, given.scale_numbers[0] * flight.principal_distance
    )
    said = terrain_forecast.describe_forecast(forecast, by_camera)
    return replace(
        given,
        text=f"{given.text}\n\n{said}",
        tables=lambda: {
            **given.tables(),
            "dangerous_surfaces": forecast,
            "dangerous_surfaces_by_camera": by_camera,
        },
    )
