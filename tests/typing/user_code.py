"""Code as users write it: read by a type checker in test_public_types, never run."""

from pathlib import Path
from typing import assert_type

import numpy as np
import pandas as pd

import einschalt as es


def compute(folder: Path) -> pd.DataFrame:
    """A block from its folder to its files."""
    block = es.read_block(folder, {"crs_accuracy_m": 2.0})
    assert_type(block, es.Block)
    settings = es.Settings(coverage_mean="most_central").updated({"iterations": 2})
    result = es.densify(block, settings, progress=print)
    assert_type(result, es.DensificationResult)
    assert_type(result.models, pd.DataFrame)
    assert_type(result.residuals, pd.DataFrame)
    assert_type(result.settings, es.Settings)
    text = assert_type(result.summary(), str)
    with es.written_in("de"):
        text += result.summary()
    text += result.summary(language="en")
    result.write(folder / "out", ellipse_scale=100.0, overwrite=bool(text))
    name: str = result.publish("NAME", folder / "names", crs="EPSG:31255").summary()
    files: list[Path] = [one.path for one in result.export("a.dxf", "b.xlsx")]
    again: list[Path] = [one.path for one in es.export(folder / "out", "c.kml")]
    es.publish(folder / "out", name, "names", crs=result.crs)
    if result.claim is not None and not assert_type(result.claim.is_supported, bool):
        return result.points[result.points["is_suspect"]]
    with_errors: bool = result.errors is not None and block.low_flight.n_models > 1
    if with_errors:
        pairs = [("1", "2")]
        covariances: np.ndarray = result.covariance_between(pairs)
        return result.neighbour_precision(pairs).head(len(covariances))
    axes = result.plot.precision(result.plot.map(layers=["models", "ellipses"]))
    axes.set_title(repr(result.plot))
    result.report(folder / "report.html", overwrite=True, language="de")
    result.write(folder / "printed", report=True, paper="a4")
    n_places = len(result.to_geodataframe())
    seconds = assert_type(result.seconds, float)
    return result.points.head(int(seconds) + n_places + len(files) + len(again))


def compute_many(folders: list[Path]) -> pd.DataFrame:
    """Many blocks, and what several results say."""
    given = {"method": "auto"}
    return es.densify_many(folders, "results", settings=given, which="unfinished")


def make_block(folder: Path, frame: pd.DataFrame) -> es.Block:
    """A block from frames, and one with known truth."""
    camera = es.Camera.from_opencv(8000, 8000, 3999.5, 2999.5, pixel_size_um=5)
    high = es.Flight(
        image_points=frame, models=frame, camera=camera, scale_number=15_000, m_g_um=7.5
    )
    low = es.Flight(frame, scale_number=8_000, m_g_um=5.0)
    control = es.read_points("points.csv", {"easting": "Rechtswert"}, decimal=",")
    block = es.Block(control_points=control, high_flight=high, low_flight=low)
    block.write(folder, overwrite=True)
    xy: np.ndarray = camera.xy_from_measured([[1.0, 2.0]])
    geometry = es.BlockGeometry(width=float(xy[0, 0]), height=3_000.0)
    noise = es.BlockNoise(low_m_g_um=4.0)
    simulated = es.simulate_block("demo", seed=1, geometry=geometry, noise=noise)
    truth = assert_type(simulated.truth, pd.DataFrame)
    simulated.write(folder / str(len(truth)))
    return simulated


def stages(block: es.Block, frame: pd.DataFrame) -> pd.DataFrame:
    """The five stages by themselves."""
    approximate = es.approximate_coordinates(frame, frame, "helmert")
    oriented = es.relative_orientation(block.low_flight, outliers="snoop")
    fit = es.transform_models(oriented.model_points, approximate.points)
    pipeline = assert_type(fit.proj_pipeline("1/2"), str)
    values = fit.transform(frame).assign(pipeline=pipeline)
    matrix = assert_type(fit.covariance("1/2"), pd.DataFrame)
    total = assert_type(es.error_budget(5.0, 8000, fit.m_0), float)
    means = es.average_coverages(values, coverage_mean="all", weighting="plain")
    bent = fit.distributed(method="collocation")
    bent.publish("NAME", "names", crs="EPSG:3067")
    return means.points.assign(total=total).join(matrix).join(bent.held_out)


def adjust(block: es.Block, frame: pd.DataFrame) -> float:
    """All models at once, and orientations."""
    adjusted = es.adjust_block(block, kind="helmert", deformation=("quadratic",))
    by_parallaxes = es.orient_from_parallaxes(frame, 92.0, method="krames")
    by_images = es.orient_from_images(frame, 153.0, base_length=92.0)
    sigma = float(by_parallaxes.sigma_0.iloc[0] + by_images.sigma_0.iloc[0])
    corrected = by_parallaxes.corrected(frame)
    return (
        assert_type(adjusted.s_0, float)
        + len(assert_type(adjusted.cofactor("1/2", flight="low_flight"), pd.DataFrame))
        + sigma
        + len(corrected)
        + len(adjusted.summary())
    )


def of_camera(name: str) -> es.PlanFrame:
    """A camera and how it is flown."""
    camera: es.CameraPreset = es.camera_preset(name)
    assert_type(camera.max_height, float | None)
    return es.PlanFrame.of_camera(camera, kind="rigid")


def of_target(plan: es.CheckedPlan) -> str:
    """What is read of a plan that was checked."""
    searched: es.PlanSearch = plan.search
    expected: es.ExpectedPrecision = plan.expected
    assert_type(expected.figures.mean, float)
    other = plan if plan.next_best is None else plan.next_best
    errors = [assert_type(error, float) for _, error in plan.missed]
    cost = other.plan["cost"] + plan.reached + sum(errors)
    return f"{assert_type(plan.outcome(), str)}{searched.verdict}{cost}"


def of_area(plan: es.AreaPlan) -> str:
    """What is read of the parts of a plan over an area."""
    flown: es.FlightPlan = plan.flown
    assert_type(flown.cost, float)
    assert_type(plan.checked.is_kept, bool)
    assert_type(plan.layout.area.square_km, float)
    assert_type(plan.layout.n_left_out, int)
    centres: np.ndarray = plan.layout.flights["low_flight"].rasters[0].centres()
    inside: np.ndarray = plan.area.holds(plan.area.to_local(centres))
    heights = plan.heights
    if heights is not None:
        inside = inside & (heights.straight_below(centres) < heights.range[1])
    length, width = assert_type(plan.area.extent, tuple[float, float])
    said = assert_type(plan.area.describe(), str)
    return (
        said + assert_type(plan.checked.verdict(), str) + f"{length} {width} {inside}"
    )


def plan() -> pd.DataFrame:
    """Before the flight."""
    best = assert_type(es.optimal_scale([200, 300], 0.10, 10), pd.DataFrame)
    try:
        table: pd.DataFrame = es.plan_precision([6000, 8000], 300, 0.10, 10)
    except es.EinschaltError as error:
        where: str = error.where + error.remedy + es.__version__
        raise SystemExit(where) from error
    design = es.FlightDesign(scale_number=8000, spacing=300, m_g_um=5)
    expected = es.expect_precision(design, coverage_mean="all")
    choices = es.PlanChoices(scale_number=(8000,), spacing=(300,), m_g_um=(5,))
    frame = es.PlanFrame(kind="rigid", costs=es.PlanCosts(image=12.5))
    found = es.find_plans(expected.figures.mean, choices, frame)
    plan = es.plan_area(0.05, "area.gpkg", choices, crs="EPSG:31255")
    if not plan.is_recommended:
        raise SystemExit(plan.verdict())
    said = of_area(plan) + of_target(es.plan_target(0.05, choices, of_camera("dmc_3")))
    row = es.expect_precision(found.nearest, frame=frame)
    found.plot.costs(row.plot.map()).set_title(said)
    tried = es.simulate_plan(found.nearest, frame=es.PlanFrame(kind="rigid"), seed=1)
    for one in (plan, design, expected, Path("plan")):
        truth = assert_type(es.simulate_plan(one, n_check=5).truth, pd.DataFrame)
        tried.write(Path("tried") / str(len(truth)))
    found.plot.costs(expected.plot.map()).set_title(found.verdict)
    return pd.concat([best, table, found.feasible])
