"""Every argument of the public interface with values of every wrong kind."""

import datetime as dt
from dataclasses import fields
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import shapely

import einschalt as es
from einschalt.foundations.arguments import as_numbers, as_path, described
from einschalt.foundations.errors import FileError, SettingsError, TableError
from einschalt.interfaces.programs import export
from einschalt.stages.stage2_relative_orientation import image_pairs

ROOT = Path(__file__).parents[2]
KINDS = {
    "None": None,
    "a dict": {"a": 1},
    "a text": "wide",
    "no text": "",
    "a list": [1.0, 2.0],
    "an empty list": [],
    "a list of lists": [[1.0], [2.0, 3.0]],
    "nan": float("nan"),
    "infinity": float("inf"),
    "a negative number": -1,
    "nothing": 0,
    "a truth value": True,
    "a number beyond floats": 10**400,
    "a number that Python does not write": 10**5000,
    "the largest float": 1e308,
    "a complex number": 1j,
    "bytes": b"x",
    "an array": np.zeros(3),
    "an array of a wrong shape": np.zeros((2, 2, 2)),
    "an array of objects": np.array([{}, []], dtype=object),
    "an empty array": np.zeros(0),
    "a series": pd.Series([1.0, 2.0]),
    "an empty frame": pd.DataFrame(),
    "a frame of objects": pd.DataFrame({"point_id": [{}], "easting": [[1]]}),
    "a class": int,
    "a module": np,
    "a generator": (k for k in range(3)),
    "a set": {1},
    "a date": dt.date(1971, 1, 1),
    "no value": pd.NA,
    "half a surrogate pair": "\udcff",
    "a text with a NUL": "a\0b",
}
SPOILT = {
    "levels of columns": lambda t: pd.concat({"a": t}, axis=1),
    "no rows": lambda t: t.head(0),
    "a column twice": lambda t: pd.concat([t, t[["x"]]], axis=1),
    "complex numbers": lambda t: t.assign(x=t["x"] * 1j),
    "lists in cells": lambda t: t.assign(x=[[1]] * len(t)),
    "dates": lambda t: t.assign(x=pd.Timestamp("1971-01-01")),
    "durations": lambda t: t.assign(x=pd.Timedelta(1, "s")),
    "numbers beyond floats": lambda t: t.assign(x=10**400),
    "numbers whose squares overflow": lambda t: t.assign(x=1e200),
    "bytes as names": lambda t: t.assign(point_id=b"x"),
    "lists as names": lambda t: t.assign(point_id=[[1]] * len(t)),
    "half surrogates in names": lambda t: t.assign(
        point_id=pd.Series(["\udcff"] * len(t), index=t.index, dtype=object)
    ),
}


@pytest.fixture(scope="module")
def calls(demo_block, tmp_path_factory):
    """Every public call with arguments that are right."""
    block = es.simulate_block("demo", seed=1)
    assert len(block.truth) == len(demo_block.truth)
    points, control = block.low_flight.model_points, block.control_points
    high = block.high_flight
    parallaxes, images = (
        es.simulate_block("demo", geometry=es.BlockGeometry(measurement=how))
        for how in ("parallaxes", "images")
    )
    approximate = es.approximate_coordinates(high.model_points, control)
    ground = approximate.points[["point_id", "easting", "northing"]]
    fit = es.transform_models(points, ground)
    values = fit.transform(points).rename(columns={"m_t": "standard_error_paper"})
    pairs = image_pairs(images.low_flight.image_points, images.low_flight.models)
    of_flight = {
        f.name: getattr(parallaxes.low_flight, f.name) for f in fields(es.Flight)
    }

    def block_of(**facts):
        control = parallaxes.control_points
        flights = {"low_flight": es.Flight(**facts), "high_flight": high}
        return es.Block(control_points=control, **flights)

    return {
        "read_block": (es.read_block, {"path": "nowhere"}),
        "read_points": (
            es.read_points,
            {
                "path": ROOT / "data_examples" / "neukirchen" / "control_points.csv",
                "columns": {"easting": "easting"},
                **dict.fromkeys(("layer", "sheet", "decimal", "crs")),
            },
        ),
        "Block": (
            es.Block,
            {
                "low_flight": block.low_flight,
                "high_flight": high,
                "control_points": control,
                "approximate_m_0_m": None,
                "crs": block.crs,
                "name": "x",
                "settings": es.Settings(),
                "sources": {},
                "checksums": {},
                "notes": (),
                "may_be_unmeasured": False,
            },
        ),
        "Flight": (block_of, of_flight),
        "Settings": (es.Settings, es.Settings().model_dump()),
        "densify": (es.densify, {"block": block, "settings": None}),
        "adjust_block": (
            es.adjust_block,
            {
                "block": block,
                "kind": "affine",
                "flights": "both",
                "deformation": "ignored",
                "outliers": "keep",
                "significance": 0.001,
                "variance_components": "given",
            },
        ),
        "approximate_coordinates": (
            es.approximate_coordinates,
            {"model_points": high.model_points, "control_points": control},
        ),
        "relative_orientation": (es.relative_orientation, {"flight": high}),
        "transform_models": (
            es.transform_models,
            {
                "model_points": points,
                "ground_points": ground,
                "kind": "affine",
                "weights": None,
            },
        ),
        "ModelTransformation.transform": (fit.transform, {"model_points": points}),
        "error_budget": (
            es.error_budget,
            {"m_g_um": 5.0, "scale_number": 8000, "m_t": 0.02},
        ),
        "average_coverages": (
            es.average_coverages,
            {"values": values, "coverage_mean": "all", "weighting": "plain"},
        ),
        "orient_from_parallaxes": (
            es.orient_from_parallaxes,
            {
                "y_parallaxes": parallaxes.low_flight.y_parallaxes,
                "base": parallaxes.low_flight.base,
                "case": "independent",
                "method": "least_squares",
            },
        ),
        "orient_from_images": (
            es.orient_from_images,
            {
                "image_pairs": pairs,
                "principal_distance": 153.0,
                "base_length": None,
                "case": "dependent_right",
                "estimator": "rigorous",
            },
        ),
        "densify_many": (
            es.densify_many,
            {
                "blocks": (),  # so that nothing is computed where all is right
                "output": tmp_path_factory.mktemp("results"),
                "scheduler": None,
                "settings": None,
                "workers": None,
                "memory_gb": None,
                "which": "changed",
                "progress": None,
            },
        ),
        "simulate_block": (
            es.simulate_block,
            {"preset": "demo", "geometry": None, "noise": None},
        ),
        "BlockGeometry": (es.BlockGeometry, vars(es.BlockGeometry())),
        "BlockNoise": (es.BlockNoise, vars(es.BlockNoise())),
        "Camera.from_opencv": (
            es.Camera.from_opencv,
            {
                "fx": 3000.0,
                "fy": 3000.0,
                "cx": 9.0,
                "cy": 9.0,
                "distortion": (),
                "pixel_size_um": 4.0,
            },
        ),
        "Camera.from_metashape": (
            es.Camera.from_metashape,
            {
                "f": 3000.0,
                "size": (4000, 3000),
                "centre": (0.0, 0.0),
                "distortion": None,
                "pixel_size_um": 4.0,
            },
        ),
        "Camera.from_mm": (
            es.Camera.from_mm,
            {
                "c": 153.0,
                "principal_point": (0.0, 0.0),
                "distortion": None,
                "pixels": None,
            },
        ),
    }


NAMES = [
    "read_block",
    "Block",
    "Flight",
    "Settings",
    "read_points",
    "densify",
    "adjust_block",
    "approximate_coordinates",
    "relative_orientation",
    "transform_models",
    "ModelTransformation.transform",
    "error_budget",
    "average_coverages",
    "orient_from_parallaxes",
    "orient_from_images",
    "densify_many",
    "simulate_block",
    "BlockGeometry",
    "BlockNoise",
    "Camera.from_opencv",
    "Camera.from_metashape",
    "Camera.from_mm",
]


SLOW = {"Flight": 6, "Block": 3}  # each argument meets every so many kinds a time


def outcome(function, arguments):
    """Text of the error, or None where the value was taken."""
    try:
        function(**arguments)
    except es.EinschaltError as error:
        return str(error)
    return None


@pytest.mark.parametrize("name", NAMES)
def test_no_value_of_a_wrong_kind_ends_in_another_error(
    name, calls, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)  # some texts name a folder, which is made
    function, right = calls[name]
    step = SLOW.get(name, 1)
    for place, (argument, given) in enumerate(right.items()):
        for what, value in list(KINDS.items())[place % step :: step]:
            said = outcome(function, {**right, argument: value})
            # a few of them are right: None where it is the default, a number
            assert said is None or len(said) < 2000, (argument, what)
        if isinstance(given, pd.DataFrame) and "x" in given:
            for what, spoil in SPOILT.items():
                said = outcome(function, {**right, argument: spoil(given)})
                assert said is not None, (argument, what)


@pytest.mark.parametrize(
    ("name", "argument", "value", "said"),
    [
        (
            "Block",
            "low_flight",
            {},
            r"low_flight = a dict.*expected a Flight\. Write F",
        ),
        ("Block", "settings", {}, r"settings = a dict.*expected Settings, such as"),
        ("Block", "crs", [1], r"crs = \[1\]; expected an EPSG code"),
        (
            "Block",
            "name",
            "\udcff",
            r"name = '.udcff' is no Unicode text; expected the",
        ),
        ("Block", "control_points", [1.0], r"\[1.0\] is no table; expected a"),
        (
            "Flight",
            "camera",
            "c.toml",
            r"camera = 'c.toml'; expected a Camera\. Make it",
        ),
        ("Flight", "model_unit", ["mm"], r"model_unit = \['mm'\] is unknown"),
        (
            "densify",
            "settings",
            {},
            r"settings is a dict; expected Settings\. Write Se",
        ),
        (
            "densify",
            "block",
            "out",
            r"densify was given a str; expected a Block\. Read",
        ),
        ("adjust_block", "block", 5, r"block = 5; expected a Block"),
        ("relative_orientation", "flight", {}, r"flight = a dict.*expected a Flight"),
        ("transform_models", "kind", ["affine"], r"kind = \['affine'\] is unkn"),
        (
            "transform_models",
            "kind",
            "afine",
            r"unknown; expected affine or .*=\"affine",
        ),
        (
            "transform_models",
            "weights",
            "1",
            r"weights = '1'; expected a Series by poi",
        ),
        ("transform_models", "model_points", {}, r"model_points: a dict .*is no table"),
        ("error_budget", "m_t", "0.02", r"m_t = '0.02'; expected a number, or an arra"),
        ("error_budget", "m_t", None, r"m_t = None; expected a number, or an array"),
        ("average_coverages", "values", {}, r"values = a dict.*a DataFrame with point"),
        ("orient_from_parallaxes", "base", [1.0], r"base = \[1.0\]; expect"),
        (
            "orient_from_images",
            "case",
            1,
            r"case = 1 is unknown; expected independent|dep",
        ),
        ("densify_many", "blocks", 3, r"blocks = 3; expected a folder below which"),
        ("densify_many", "blocks", [3], r"blocks = 3; expected the path of a"),
        ("densify_many", "output", "", r"output = ''; expected the path of a"),
        ("densify_many", "settings", "all", r"settings = 'all'; expected Settings, or"),
        ("densify_many", "settings", {1: 2}, r"settings = a dict.*names of settings"),
        ("densify_many", "workers", True, r"workers = True; expected a whole number"),
        ("densify_many", "memory_gb", "4", r"memory_gb = '4'; expected a number ab"),
        ("densify_many", "scheduler", 3, r"scheduler = 3; expected the address of"),
        ("densify_many", "which", 3, r"which = 3; expected changed or unfinished"),
        ("densify_many", "progress", 3, r"progress = 3; expected a function of the n"),
        (
            "simulate_block",
            "preset",
            {},
            r"preset a dict.* is unknown; expected neukir",
        ),
        (
            "BlockGeometry",
            "high_cross_flight",
            1,
            r"high_cross_flight = 1; expected True",
        ),
        (
            "Camera.from_mm",
            "principal_point",
            1,
            r"point = 1; expected a pair of numbers",
        ),
        ("Camera.from_opencv", "fx", "3000", r"fx = '3000'; expected a number"),
    ],
)
def test_the_message_names_argument_found_expected(name, argument, value, said, calls):
    function, right = calls[name]
    with pytest.raises(es.EinschaltError, match=said):
        function(**{**right, argument: value})


def test_shapes_that_do_not_fit_each_other():
    said = (
        r"m_g_um of shape \(3,\).*m_t of shape \(2,\); expected numbers, or arrays of"
    )
    with pytest.raises(SettingsError, match=said):
        es.error_budget([1.0, 2.0, 3.0], 8000, [0.1, 0.2])


def test_a_table_with_levels_of_columns():
    table = pd.DataFrame({("a", "x"): [1.0]})
    with pytest.raises(
        TableError, match=r"column names have 2 levels; expected model_"
    ):
        es.transform_models(table, table)


def test_folders_must_be_paths(demo_block):
    block = es.simulate_block("demo", seed=1)
    for folder in (None, 3, b"out", ["out"], "", "a\0b"):
        with pytest.raises(
            FileError, match=r"folder = .*expected the path of a file or"
        ):
            block.write(folder)
        with pytest.raises(
            FileError, match=r"path = .*; expected the path of a file or"
        ):
            es.read_block(folder)


def test_names_of_any_plain_kind_stay_what_they_are():
    model = pd.DataFrame({"model_id": 1, "point_id": [1, 2], "x": [0, 1], "y": [0, 0]})
    ground = pd.DataFrame(
        {"point_id": ["1", "2"], "easting": [5.0, 7.0], "northing": [5.0, 5.0]}
    )
    fit = es.transform_models(model, ground, kind="helmert")
    assert fit.parameters.loc["1", "a"] == pytest.approx(2.0)


def test_described_is_short_whatever_is_described():
    assert described(10**5000) == "a whole number of 16610 bits"
    assert described("x" * 1000).endswith("xxx'")
    assert len(described("x" * 1000)) <= 60
    assert described("\x1b[2J") == r"'\x1b[2J'"
    assert described(Path("out")) == "PosixPath('out')"
    assert described(np.zeros((0, 3))) == "an ndarray of shape (0, 3)"


def test_numbers_of_series_with_missing_values():
    values = as_numbers("m_t", pd.Series([0.1, np.nan]))
    assert values.tolist()[0] == 0.1
    assert np.isnan(values[1])
    with pytest.raises(SettingsError, match="m_t = an ndarray of shape"):
        as_numbers("m_t", np.array([True]))
    assert as_path("folder", Path("out")) == Path("out")


def test_advice_on_plans_names_arguments_of_python():
    """It named ``--spacing`` and ``--max-height``, which Python has not."""
    choices = es.PlanChoices(scale_number=(8000,), spacing=(300,), m_g_um=(5,))
    with pytest.raises(es.EinschaltError, match="max_height must") as caught:
        es.plan_area(0.05, shapely.box(0, 0, 400_000, 400_000), choices)
    assert "--" not in str(caught.value)
    low = es.PlanFrame(max_height=300)
    with pytest.raises(es.EinschaltError, match="max_height") as caught:
        es.find_plans(0.05, choices, low)
    assert "--" not in str(caught.value)
    missed = es.find_plans(0.011, choices)
    assert "n_settings" in str(missed)
    assert "--" not in missed.verdict + str(missed)


def printed_results():
    """What planning gives in Python: a plan over an area too, its parts with it."""
    square = shapely.box(0, 0, 7000, 6000)
    choices = partial(es.PlanChoices, spacing=(300,), m_g_um=(5,))
    scales = choices(scale_number=(9000, 11000), n_coverages=(2,))
    one = choices(scale_number=(9000,), n_coverages=(1,), high_over_low=(1.5,))
    design = es.FlightDesign(
        scale_number=8000, spacing=300, m_g_um=5, n_coverages=1, width=4e3, height=4e3
    )
    yield es.expect_precision(design)
    yield es.find_plans(0.011, scales)
    for target, asked in ((0.06, scales), (0.02, scales), (0.06, one)):
        plan = es.plan_area(target, square, asked, refine=("scale_number",))
        yield from (plan, plan.search, plan.checked, plan.checked.expected)
        other = plan.checked.next_best
        yield from () if other is None else (other, other.search)


@pytest.mark.slow
def test_no_result_of_planning_names_options():
    """Plans over an area advised ``--scale-number`` and ``--high-over-low``."""
    said = []
    for result in printed_results():
        said += [str(result), repr(result)]
        for name in ("verdict", "outcome", "dropped"):
            told = getattr(result, name, "")
            said.append(str(told() if callable(told) else told))
    assert "scale_number" in "".join(said)
    assert "n_coverages" in "".join(said)
    assert [text for text in said if "--" in text] == []


@pytest.mark.parametrize("given", [{}, "film_wide", 0.05])
def test_what_is_no_frame_is_refused_alike_with_and_without_an_area(given):
    """An area answered with a TypeError of dataclasses."""
    choices = es.PlanChoices(scale_number=(8000,), spacing=(300,), m_g_um=(5,))
    said = []
    for plan in (
        es.find_plans,
        partial(es.plan_area, area=shapely.box(0, 0, 6000, 6000)),
    ):
        with pytest.raises(SettingsError, match=r"frame = .*a PlanFrame") as caught:
            plan(0.05, choices=choices, frame=given)
        said.append(str(caught.value))
    assert said[0] == said[1]


def test_photographs_follow_no_terrain_without_heights():
    """It was passed over, and a plan over level ground given."""
    choices = es.PlanChoices(scale_number=(8000,), spacing=(300,), m_g_um=(5,))
    area = shapely.box(0, 0, 6000, 6000)
    with pytest.raises(SettingsError, match="follows_terrain = True without heights"):
        es.plan_area(0.05, area, choices, follows_terrain=True)


@pytest.mark.slow
def test_a_plan_over_an_area_is_asked_where_its_target_holds():
    """As ``--where`` and ``--by`` do: in the centre of models it takes less."""
    area = shapely.box(0, 0, 7000, 6000)
    choices = es.PlanChoices(
        scale_number=(7000, 8000, 9000, 10000),
        spacing=(300,),
        m_g_um=(5,),
        n_coverages=(1,),
    )
    plans = {w: es.plan_area(0.065, area, choices, where=w) for w in ("edge", "centre")}
    assert {w: plan.checked.place for w, plan in plans.items()} == {
        "edge": "edge",
        "centre": "centre",
    }
    edge, centre = (plan.checked.plan["cost"] for plan in plans.values())
    assert centre < edge
    by_paper = es.plan_area(0.065, area, choices, where="edge", by="paper")
    assert by_paper.search.by == "paper"
    with pytest.raises(SettingsError, match="where"):
        es.plan_area(0.065, area, choices, where="corner")


def test_prices_have_a_public_name():
    costs = es.PlanCosts(image=12, control_point=60)
    found = es.find_plans(
        0.05,
        es.PlanChoices(scale_number=8000, spacing=300, m_g_um=5),
        es.PlanFrame(costs=costs),
    )
    assert found.plans["cost"].gt(0).all()
    with pytest.raises(es.EinschaltError, match="image = -1"):
        es.PlanCosts(image=-1)


@pytest.mark.parametrize("name", ["x" * 300, "x/" * 5000, "ä" * 200])
def test_a_name_that_no_file_can_have_is_said_once(name, tmp_path, good_result):
    """The system refuses to look for it: that was an OSError of each function."""
    long, here = tmp_path / name, tmp_path / "here.dxf"
    calls = {
        "path": [lambda: es.read_block(long), lambda: es.read_points(long)],
        "file": [lambda: es.export(good_result, f"{long}.dxf")],
        "result": [lambda: es.export(long, here)],
        "blocks": [
            lambda: es.densify_many(long, tmp_path),
            lambda: es.densify_many([long], tmp_path),
        ],
        "output": [lambda: es.densify_many([tmp_path], long)],
        "plan": [lambda: es.simulate_plan(long)],
        "folder": [lambda: es.simulate_block("demo").write(long)],
    }
    for argument, functions in calls.items():
        for function in functions:
            with pytest.raises(FileError) as refused:
                function()
            assert str(refused.value).startswith(f"{argument} = ")
            assert "can be no file: file name too long. Correct" in str(refused.value)
    assert list(tmp_path.iterdir()) == []


def test_a_name_too_long_for_what_belongs_to_the_file(
    tmp_path, good_result, monkeypatch
):
    def write(_handed, path):
        path.with_name(f"{path.stem}_names.csv").write_text("")

    monkeypatch.setitem(export.WRITERS, ".con", write)
    with pytest.raises(FileError, match="cannot be written: file name too long"):
        es.export(good_result, tmp_path / f"{'p' * 251}.con")
    assert list(tmp_path.iterdir()) == []
