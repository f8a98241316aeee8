"""Draw the figures of the site from our own numbers: ``make drawings``."""

from pathlib import Path

import matplotlib as mpl
import numpy as np
import pandas as pd
from matplotlib import pyplot as plt

import einschalt as es
from einschalt.theory.relative_orientation import gruber, hallert
from einschalt.theory.relative_orientation import parallax_equations as equations
from einschalt.theory.relative_orientation.six_points import FROM_1_TO_6

ROOT = Path(__file__).parents[1]
IMAGES = ROOT / "docs" / "images"
BLUE, BROWN, GREY = "#0b5c6b", "#c0722e", "#8a9499"
# the same file from the same numbers; on white, so that dark pages show it as well
mpl.rcParams |= {"svg.hashsalt": "einschalt", "font.size": 10, "svg.fonttype": "none"}
DATA = ROOT / "data_examples"


def save(figure, name):
    """Write a figure below docs/images: a drawing, or a small picture of a recipe."""
    file = IMAGES / name
    file.parent.mkdir(exist_ok=True)
    same = {"Date": None} if file.suffix == ".svg" else {"Software": None}
    figure.savefig(file, metadata=same, dpi=72 if file.suffix == ".svg" else 90)
    plt.close(figure)


def empty(width=4.0, height=2.8):
    """A figure without frame."""
    figure, axes = plt.subplots(figsize=(width, height), layout="constrained")
    axes.spines[["top", "right"]].set_visible(False)
    return figure, axes


def leverage():
    """Leverage times number of points over a model that is fully covered, affine."""
    place = (np.arange(41) - 20) / 20.5  # the middles of 41 equal parts
    x, y = (a.ravel() for a in np.meshgrid(place, place))
    design = np.column_stack([np.ones_like(x), x, y])
    hat = np.einsum("ij,jk,ik->i", design, np.linalg.inv(design.T @ design), design)
    figure, axes = empty(4.2, 4.0)
    levels = axes.contour(
        place, place, (len(x) * hat).reshape(41, 41), np.arange(1.5, 7), colors=BLUE
    )
    axes.clabel(levels)
    for (a, b), value in {(0, 0): 1, (0.9, 0): 4, (0.9, 0.9): 7}.items():
        axes.annotate(f"{value}", (a, b), ha="center", color=BROWN, weight="bold")
    axes.set(xticks=[-1, 0, 1], yticks=[-1, 0, 1], aspect="equal")
    axes.set(xlabel="middle (0) to edge (1) along the strip", ylabel="across the strip")
    save(figure, "leverage.svg")


def error_over_scale(name, size=(6.4, 3.8)):
    """M at the edge of a model over the image scale, for several spacings."""
    spacings = [100, 200, 300, 400]
    scales = np.linspace(5000, 14000, 60)
    best = es.optimal_scale(spacings, m_0=0.093, m_g_um=5)
    lines = es.plan_precision(scales, spacings, m_0=0.093, m_g_um=5)
    figure, axes = empty(*size)
    for spacing, line in lines.groupby("spacing"):
        error = 100 * line["M_edge"].to_numpy()
        axes.plot(scales, error, color=BLUE)
        axes.annotate(f"{spacing:.0f} m ", (scales[0], error[0]), ha="right")
    axes.plot(best["scale_number"], 100 * best["M_edge"], "o", color=BROWN)
    axes.set(xlim=(3000, 14200), ylim=(0, 12))
    axes.set(xlabel="scale number", ylabel="M at the edge, total [cm]")
    save(figure, name)


def dangerous_cylinder():
    """A valley across the base that follows the cylinder through both centres."""
    figure, axes = empty(5.2, 4.2)
    angle = np.linspace(0, 2 * np.pi, 200)
    axes.plot(0.6 * np.sin(angle), -0.6 + 0.6 * np.cos(angle), "--", color=BROWN)
    across = np.linspace(-0.55, 0.55, 100)
    axes.plot(across, -0.6 - np.sqrt(0.36 - across**2), color=BLUE, lw=3)
    for slope in (-0.5, 0, 0.5):
        axes.plot([0, slope], [0, -0.6 - np.sqrt(0.36 - slope**2)], color=GREY, lw=1)
    axes.plot(0, 0, "o", color="black")
    axes.annotate("  base, seen from its end", (0, 0.02))
    axes.annotate("dangerous cylinder", (0.42, -0.12), color=BROWN)
    axes.annotate("floor and slopes of a valley", (0, -1.3), ha="center", color=BLUE)
    axes.set(aspect="equal", xlim=(-0.9, 1.1), ylim=(-1.4, 0.15))
    axes.set_axis_off()
    save(figure, "dangerous_cylinder.svg")


def map_of_block():
    """Precision of the points of the simulated block."""
    block = es.read_block(DATA / "neukirchen")
    points = es.densify(block).points
    figure, axes = empty()
    colour = axes.scatter(
        points["easting"],
        points["northing"],
        3,
        100 * points["standard_error_total"],
        vmin=3.5,
        vmax=6.5,
        cmap="cividis",
    )
    figure.colorbar(colour, label="total [cm]")
    axes.set_aspect("equal")
    axes.set_axis_off()
    save(figure, "recipes/densify_block.png")


def arrows_of_real_block():
    """Differences at the known points of Strasbourg."""
    points = es.densify(es.read_block(DATA / "sxb_strasbourg")).points
    known = points[points["role"] != "new"]
    figure, axes = empty()
    axes.plot(points["easting"], points["northing"], ".", ms=2, color=GREY)
    axes.quiver(
        *known[["easting", "northing", "difference_easting", "difference_northing"]]
        .to_numpy()
        .T,
        color=BROWN,
    )
    axes.set_aspect("equal")
    axes.set_axis_off()
    save(figure, "recipes/densify_real_block.png")


def truth_and_claims():
    """True error beside what is said of it."""
    block = es.simulate_block("neukirchen", seed=1)
    result = es.densify(block, es.Settings(coverage_mean="most_central"))
    new = result.points[result.points["role"] == "new"].set_index("point_id")
    plan = ["easting", "northing"]
    error = new[plan] - block.truth.set_index("point_id").loc[new.index, plan]
    shown = {
        "differences": result.figures.mean_internal,
        "formula of 1971": result.figures.mean_paper,
        "propagated": result.figures.mean_total,
        "truth": np.sqrt((error**2).sum(axis=1).mean()),
    }
    figure, axes = empty()
    axes.barh(
        list(shown), [100 * v for v in shown.values()], color=[BLUE] * 3 + [BROWN]
    )
    axes.set_xlabel("total [cm]")
    save(figure, "recipes/simulate_and_compare.png")


def strain_of_finland():
    """Residuals of one affine transformation of the country."""
    old, new = (
        pd.read_csv(DATA / "fi_ykj_tm35fin" / f"{name}_points.csv")
        for name in ("model", "ground")
    )
    residuals = es.transform_models(old, new, kind="affine").residuals
    shown = residuals.merge(new, on="point_id", suffixes=("", "_given"))
    columns = ["easting", "northing", "residual_easting", "residual_northing"]
    figure, axes = empty()
    axes.quiver(*shown[columns].to_numpy().T, color=BLUE, width=0.004)
    axes.set_aspect("equal")
    axes.set_axis_off()
    save(figure, "recipes/transform_national_frames.png")


def repetitions():
    """Two elements of 25 orientations of one pair."""
    case, sigma = "dependent_right", 0.01
    xyz = hallert.flat_six_points(95.0, 92.0, 152.0)[FROM_1_TO_6]
    design = equations.design_matrix(xyz, 92.0, case)
    procedure = gruber.standard_procedure(design, case, tilt_at="5")
    record = gruber.run_procedure(
        procedure,
        design,
        np.zeros((25, 6)),
        n_passes=3,
        sigma=sigma,
        rng=np.random.default_rng(1932),
    )
    figure, axes = empty()
    axes.plot(*(1e3 * record.elements[-1][:, :2]).T, "o", color=BLUE, ms=4)
    axes.axhline(0, color=GREY, lw=0.5)
    axes.axvline(0, color=GREY, lw=0.5)
    axes.set(xlabel="first element · 1000", ylabel="second")
    save(figure, "recipes/finsterwalder_repetitions.png")


if __name__ == "__main__":
    leverage()
    error_over_scale("error_over_scale.svg")
    error_over_scale("recipes/reproduce_kovarik_1971.png", (4.0, 2.8))
    dangerous_cylinder()
    map_of_block()
    arrows_of_real_block()
    truth_and_claims()
    strain_of_finland()
    repetitions()
