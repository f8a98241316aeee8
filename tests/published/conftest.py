"""Published cases: read, and turned into the tables that a user would have."""

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import einschalt as es

CASES = Path(__file__).parent / "cases"
SOURCE = ["x", "y", "z"]
TARGET = ["easting", "northing", "height"]


@pytest.fixture
def read_case():
    """Reader of a case by its name."""

    def read(name):
        return json.loads((CASES / f"{name}.json").read_text(encoding="utf-8"))

    return read


@pytest.fixture
def model_table():
    """Maker of a table of model points; the points are named a, b, c, …"""

    def table(coordinates, **columns):
        coordinates = np.asarray(coordinates, dtype=float)
        frame = pd.DataFrame(coordinates, columns=SOURCE[: coordinates.shape[1]])
        names = [chr(ord("a") + place) for place in range(len(frame))]
        return frame.assign(model_id="7/8", point_id=names, **columns)

    return table


@pytest.fixture
def transform_case(model_table):
    """Fit of a case's ``source`` onto its ``target`` by the public function."""

    def transform(data, kind, weights=None):
        model = model_table(data["source"])
        target = np.asarray(data["target"], dtype=float)
        ground = pd.DataFrame(target, columns=TARGET[: target.shape[1]])
        ground["point_id"] = model["point_id"]
        return es.transform_models(model, ground, kind=kind, weights=weights)

    return transform


@pytest.fixture
def residuals_of():
    """Residuals of a transformation as an array."""

    def residuals(fit):
        names = [f"residual_{name}" for name in TARGET]
        return fit.residuals[[n for n in names if n in fit.residuals]].to_numpy()

    return residuals


@pytest.fixture
def transformed(model_table):
    """Points transformed by the public function, as an array."""

    def transform(fit, coordinates):
        table = fit.transform(model_table(coordinates))
        return table[[n for n in TARGET if n in table]].to_numpy()

    return transform
