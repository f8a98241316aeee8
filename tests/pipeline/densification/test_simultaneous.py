"""The simultaneous adjustment of a block, alone and beside the two-step way."""

import re
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from scipy import stats
from scipy.optimize import least_squares

import einschalt as es
from einschalt.foundations.errors import GeometryError, SettingsError
from einschalt.foundations.language import written_in
from einschalt.foundations.typesetting import length
from einschalt.interfaces.reports.html_report import render
from einschalt.pipeline.summary.summary import summarize
from einschalt.stages.simultaneous.adjustment import simultaneous_adjustment
from einschalt.stages.simultaneous.observations import MeasuredFlight, code_block

POINTS = ["easting", "northing"]
KIND = "affine"


@pytest.fixture(scope="module")
def block():
    return es.simulate_block("demo", seed=4)


@pytest.fixture(scope="module")
def adjusted(block):
    return es.adjust_block(block)


@pytest.fixture(scope="module")
def result(block):
    return es.densify(block, es.Settings(method="simultaneous"))


def with_control(block, **columns):
    return replace(block, control_points=block.control_points.assign(**columns))


def test_control_too_sparse_for_any_model_is_enough_for_all_of_them():
    block = es.simulate_block("neukirchen", seed=1)
    few = block.control_points.iloc[::12].reset_index(drop=True)
    block = replace(block, control_points=few)
    assert len(few) == 11
    assert len(block.model_problems) == 67  # all of the high flight
    points = es.densify(block, es.Settings(method="simultaneous")).points
    true = block.truth.set_index("point_id").loc[points["point_id"], POINTS].to_numpy()
    error = points[POINTS].to_numpy() - true
    # eleven points hang together more than a hundred: one block scatters by 15 %
    claimed = np.sqrt((points["standard_error_total"] ** 2).mean())
    assert np.sqrt((error**2).sum(axis=1).mean()) == pytest.approx(claimed, rel=0.3)
    assert claimed < 0.065
    with pytest.raises(es.EinschaltError, match="Or adjust all models together"):
        es.densify(block)


def test_equals_a_plain_least_squares_of_scipy(block, adjusted):
    """Every model and point an unknown, from the tables alone."""
    flights = {"high_flight": block.high_flight, "low_flight": block.low_flight}
    tables = [
        flight.model_points.assign(
            flight=name,
            sigma=flight.m_g_um * 1e-6 * flight.scale_number / np.sqrt(2.0),
        )
        for name, flight in flights.items()
    ]
    rows = pd.concat(tables, ignore_index=True)
    control = block.control_points.query("role == 'control'")
    model = rows.groupby(["flight", "coverage", "model_id"]).ngroup().to_numpy()
    ids, point = np.unique(rows["point_id"].to_numpy(str), return_inverse=True)
    n_models, n_points = model.max() + 1, len(ids)
    place = pd.Index(ids).get_indexer(control["point_id"].astype(str))
    origin = control[POINTS].mean().to_numpy()
    given = control[POINTS].to_numpy() - origin
    xy = rows[["x", "y"]].to_numpy()
    centre = np.array([xy[model == m].mean(axis=0) for m in range(n_models)])[model]
    g = np.column_stack([np.ones(len(xy)), (xy - centre) / 50.0])
    from scipy import sparse

    n = 3 * n_models + n_points
    index = np.arange(len(xy))
    design = sparse.csr_array(
        (
            np.concatenate([g.ravel(), -np.ones(len(xy)), np.ones(len(place))]),
            (
                np.concatenate(
                    [np.repeat(index, 3), index, len(xy) + np.arange(len(place))]
                ),
                np.concatenate(
                    [
                        (3 * model[:, None] + np.arange(3)).ravel(),
                        3 * n_models + point,
                        3 * n_models + place,
                    ]
                ),
            ),
        ),
        shape=(len(xy) + len(place), n),
    )
    errors = control["standard_error_m"].to_numpy() / np.sqrt(2.0)
    weight = np.concatenate([1.0 / rows["sigma"].to_numpy(), 1.0 / errors])
    whole = sparse.diags_array(weight) @ design
    for axis, name in enumerate(POINTS):
        right = np.concatenate([np.zeros(len(xy)), given[:, axis]]) * weight
        start = sparse.linalg.spsolve((whole.T @ whole).tocsc(), whole.T @ right)
        found = least_squares(
            lambda x, right=right: whole @ x - right,
            start,
            jac=lambda _x: whole,
            method="trf",
            x_scale="jac",
            tr_solver="lsmr",
            xtol=1e-15,
            gtol=1e-15,
        )
        expected = pd.Series(found.x[3 * n_models :] + origin[axis], index=ids)
        ours = adjusted.points.set_index("point_id")[name]
        np.testing.assert_allclose(ours, expected.loc[ours.index], rtol=0, atol=1e-7)


def test_gives_the_tables_that_are_promised(adjusted):
    assert list(adjusted.points.columns[:7]) == [
        "point_id",
        "easting",
        "northing",
        "standard_error_easting",
        "standard_error_northing",
        "covariance_en",
        "standard_error_total",
    ]
    assert set(adjusted.models["flight"]) == {"high_flight", "low_flight"}
    assert adjusted.models["is_usable"].all()
    assert adjusted.failures.empty
    assert adjusted.redundancy == pytest.approx(
        2 * (1.0 - adjusted.residuals["leverage"]).sum()
        + 2 * adjusted.control["redundancy_number"].sum(),
        rel=1e-9,
    )
    assert str(adjusted) == adjusted.summary()
    assert "simultaneous adjustment of" in adjusted.summary()


def test_check_points_are_called_so_and_compared(block, adjusted):
    given = block.control_points.set_index("point_id")
    points = adjusted.points.set_index("point_id")
    check = points[points["role"] == "check"]
    assert set(check.index) == set(given.index[given["role"] == "check"])
    missed = (
        check[["easting", "northing"]] - given.loc[check.index, ["easting", "northing"]]
    )
    found = check[["difference_easting", "difference_northing"]]
    np.testing.assert_array_equal(found.to_numpy(), missed.to_numpy())
    new = points[~points.index.isin(given.index)]
    assert (new["role"] == "new").all()
    assert new["difference_easting"].isna().all()
    size = length(np.sqrt((missed**2).sum(axis=1).mean()))
    said = f"{len(check)} check points off by {size} (total, RMS)"
    assert said in adjusted.summary().splitlines()
    with written_in("de"):
        assert f"{len(new)} Neupunkte, " in adjusted.summary()


def test_parameters_transform_the_models_onto_the_points(block, adjusted):
    rows = adjusted.residuals.merge(
        adjusted.models, on=["flight", "coverage", "model_id"]
    )
    measured = pd.concat(
        [
            f.model_points.assign(flight=name)
            for name, f in (
                ("high_flight", block.high_flight),
                ("low_flight", block.low_flight),
            )
        ]
    )
    rows = rows.merge(measured, on=["flight", "coverage", "model_id", "point_id"])
    rows = rows.merge(adjusted.points, on="point_id")
    easting = rows["a0"] + rows["a1"] * rows["x"] + rows["a2"] * rows["y"]
    np.testing.assert_allclose(
        easting - rows["easting"], rows["residual_easting"], atol=1e-8
    )


def test_counts_and_spread_of_points_are_those_of_their_models(adjusted):
    rows = adjusted.residuals.assign(
        whose=adjusted.residuals["flight"] + adjusted.residuals["coverage"]
    ).groupby("point_id")
    points = adjusted.points.set_index("point_id")
    same = {"check_names": False, "check_dtype": False}
    residuals = ["residual_easting", "residual_northing"]
    for name, expected in (
        ("n_models", rows.size()),
        ("n_coverages", rows["whose"].nunique()),
        (
            "spread_total",
            rows[residuals].var().sum(axis=1, min_count=2) ** 0.5,
        ),
    ):
        pd.testing.assert_series_equal(
            points[name], expected.loc[points.index], **same, rtol=1e-9
        )
    assert points["n_coverages"].min() < points["n_coverages"].max()


def test_cofactors_of_parameters_give_those_of_transformed_points(adjusted):
    """The solution has these about the centroid of each model, in units of its size."""
    solution, observations = adjusted.solution, adjusted.solution.observations
    assert adjusted.estimates.names == ("a0", "a1", "a2", "b0", "b1", "b2")
    row = np.column_stack([np.ones(len(observations.xy)), observations.xy])
    own = adjusted.estimates.cofactors[observations.model]
    easting = np.einsum("na,nab,nb->n", row, own[:, :3, :3], row)
    northing = np.einsum("na,nab,nb->n", row, own[:, 3:, 3:], row)
    expected = np.empty(len(row))
    reordered = solution.ordering.reordered.rows
    expected[reordered] = solution.solver.cofactors.transformed[:, 0, 0]
    np.testing.assert_allclose(easting, expected, rtol=1e-6)
    np.testing.assert_allclose(northing, expected, rtol=1e-6)


def test_covariance_of_a_model_of_either_flight(adjusted):
    """Both flights count their models alike."""
    models = adjusted.models
    names = models.groupby(["coverage", "model_id"])["flight"].nunique()
    coverage, model_id = names.index[names == 2][0]
    for flight in ("high_flight", "low_flight"):
        found = adjusted.covariance(model_id, coverage, flight=flight)
        is_it = (models["flight"] == flight) & (models["coverage"] == coverage)
        place = np.flatnonzero(is_it & (models["model_id"] == model_id))[0]
        own = adjusted.estimates.cofactors[place]  # σ_0 is 1
        np.testing.assert_array_equal(found, own)
        cofactor = adjusted.cofactor(model_id, coverage, flight=flight)
        np.testing.assert_array_equal(cofactor, own)
    message = (
        f"model {model_id}: flights high_flight, low_flight each have this model. "
        'Name the flight as well: flight="low_flight"'
    )
    with pytest.raises(es.EinschaltError, match=re.escape(message)):
        adjusted.covariance(model_id, coverage)
    with pytest.raises(es.EinschaltError, match="flight = 'low' is unknown"):
        adjusted.cofactor(model_id, coverage, flight="low")


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"kind": "afine"}, "kind = 'afine' is unknown; expected affine or helmert"),
        ({"flights": "upper"}, "flights = 'upper' is unknown; expected both or high"),
        ({"outliers": "drop"}, "outliers = 'drop' is unknown; expected keep or snoop"),
        ({"deformation": ("cubik",)}, "deformation = 'cubik' is unknown"),
        ({"deformation": "cubik"}, "is unknown; expected .* or a list of quadratic"),
        ({"deformation": 5}, "deformation = 5; expected .* or a list of quadratic"),
        ({"significance": 2}, "significance = 2; expected a probability above 0"),
        ({"significance": 0}, "significance = 0; expected a probability above 0"),
        ({"significance": np.nan}, "significance = nan; expected a probability"),
        ({"significance": "a"}, "significance = 'a'; expected a probability above"),
    ],
)
def test_unknown_options_are_said(block, options, message):
    with pytest.raises(SettingsError, match=message):
        es.adjust_block(block, **options)


def test_a_family_of_deformations_may_be_a_word(block):
    named = es.adjust_block(block, deformation=["cubic"]).points
    for same in ("cubic", ["cubic", "cubic"]):
        found = es.adjust_block(block, deformation=same).points
        pd.testing.assert_frame_equal(found, named)


def test_control_measured_on_a_line_is_the_cause_that_is_said():
    """Errors of measurement keep control from lying on a line exactly."""
    rng = np.random.default_rng(3)
    east, north = (v.ravel() for v in np.meshgrid(300.0 * np.arange(6), [0, 300, 600]))
    names = [f"P{k}" for k in range(len(east))]

    def measured(scale_number):
        error = rng.normal(0.0, 0.004, (2, len(east)))
        x, y = np.array([east, north]) * 1e3 / scale_number + error
        columns = {"coverage": "1", "model_id": "M", "point_id": names, "x": x, "y": y}
        return es.Flight(pd.DataFrame(columns), scale_number=scale_number, m_g_um=5.0)

    control = pd.DataFrame(
        {
            "point_id": names[:6],
            "easting": 5e6 + east[:6],
            "northing": 5.2e6 + rng.normal(0.0, 0.02, 6),
            "standard_error_m": 0.03,
        }
    )
    block = es.Block(
        control_points=control, high_flight=measured(15000), low_flight=measured(8000)
    )
    message = "control of .* lies on a line.*Give it a control point away"
    with pytest.raises(GeometryError, match=message):
        es.adjust_block(block)


@pytest.mark.parametrize("outliers", ["keep", "snoop", "huber", "tukey"])
def test_wrong_control_is_named_and_keeps_its_measurements(block, outliers):
    control = block.control_points.copy()
    worst = control.index[control["role"] == "control"][3]
    control.loc[worst, "easting"] += 1.0
    found = es.adjust_block(replace(block, control_points=control), outliers=outliers)
    suspects = found.control.query("is_suspect")
    assert list(suspects["point_id"]) == [control.loc[worst, "point_id"]]
    assert suspects["strain_easting"].item() == pytest.approx(1.0, abs=0.15)
    assert "1 of" in found.summary()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("outliers", "said"),
    [
        ("keep", r"1 control point contradicts the block, by up to"),
        ("snoop", r"1 control point set aside for contradicting the block, by up to"),
    ],
)
def test_a_summary_names_wrong_control_first_and_once(block, outliers, said):
    control = block.control_points.copy()
    worst = control.index[control["role"] == "control"][3]
    control.loc[worst, "northing"] -= 1.0
    settings = es.Settings(method="simultaneous", outliers=outliers)
    text = es.densify(replace(block, control_points=control), settings).summary()
    text = text.replace("\n    ", " ")
    name = control.loc[worst, "point_id"]
    assert re.search(rf"- {said}.*: {name}", text)
    assert ("worse than stated" in text) == (outliers == "keep")
    assert "contradict each other by more than their standard" not in text
    if outliers == "snoop":
        assert "times the expected" not in text


def test_a_block_without_a_high_flight_has_none_to_adjust(
    given_approximations_result,
):
    block = given_approximations_result.block
    with pytest.raises(
        SettingsError, match="the block has no high flight; expected low"
    ):
        es.adjust_block(block, flights="high")


def test_nothing_is_adjusted_without_control(given_approximations_result):
    block = replace(given_approximations_result.block, control_points=None)
    message = "no control points; expected control_points"
    with pytest.raises(SettingsError, match=message):
        es.adjust_block(block)
    with pytest.raises(SettingsError, match=message):
        es.densify(block, es.Settings(method="simultaneous"))


def test_a_spatial_flight_is_refused(block):
    flight = replace(block.low_flight, transformation="rigid")
    with pytest.raises(SettingsError, match="transformation = 'rigid' with method"):
        es.densify(
            replace(block, low_flight=flight), es.Settings(method="simultaneous")
        )


def test_too_little_control_for_any_model_is_said(given_approximations_result):
    block = given_approximations_result.block
    control = block.control_points
    two = control[control["role"] == "control"].head(2)
    with pytest.raises(GeometryError, match="2 control points, but affine needs 3"):
        es.adjust_block(replace(block, control_points=two))


def test_models_cut_off_are_rows_and_the_rest_is_adjusted(block, adjusted):
    low = block.low_flight.model_points
    model = low["model_id"].iloc[0]
    is_cut = (low["model_id"] == model) & (low["coverage"] == low["coverage"].iloc[0])
    names = np.where(is_cut, "lost " + low["point_id"], low["point_id"])
    cut = replace(block.low_flight, model_points=low.assign(point_id=names))
    found = es.adjust_block(replace(block, low_flight=cut))
    (row,) = found.failures.to_dict("records")
    assert (row["flight"], row["model_id"]) == ("low_flight", model)
    assert row["reason"] == (
        "no points common with other models or the control, but affine needs 3"
    )
    assert row["remedy"].startswith("Measure more common points in it")
    assert not found.points["point_id"].str.startswith("lost").any()
    assert len(found.models) == len(adjusted.models)
    assert "1 of" in found.summary()


@pytest.mark.slow
def test_wrong_control_is_named_with_size_and_direction(block):
    control = block.control_points.copy()
    worst = control.index[control["role"] == "control"][3]
    control.loc[worst, "easting"] += 0.5
    control.loc[worst, "northing"] -= 0.3
    settings = es.Settings(method="simultaneous")
    found = es.densify(replace(block, control_points=control), settings)
    suspects = found.simultaneous.control.query("is_suspect")
    assert list(suspects["point_id"]) == [control.loc[worst, "point_id"]]
    strain = suspects[["strain_easting", "strain_northing"]].to_numpy()[0]
    np.testing.assert_allclose(strain, [0.5, -0.3], atol=0.12)
    text = summarize(found)
    assert "Control points that disagree with the block" in text
    # with 0.00…0028 the column was as wide as the exponent
    assert "< 0.001" in text
    assert "0.000000" not in text
    assert "control points disagree" in found.simultaneous.summary()


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["affine", "helmert"])
def test_the_least_control_is_not_said_to_disagree(kind):
    """Nothing checks it; what pulls at it are errors in the design matrix."""
    least = {"affine": 3, "helmert": 2}[kind]
    for seed in range(8):
        block = es.simulate_block("demo", seed=seed)
        control = block.control_points[block.control_points["role"] == "control"]
        xy = control[POINTS].to_numpy()
        away = np.hypot(*(xy - xy[0]).T)
        places = [0, int(np.argmax(away))]
        aside = (xy - xy[0]) @ [[0.0, 1.0], [-1.0, 0.0]] @ (xy[places[1]] - xy[0])
        places.append(int(np.argmax(np.abs(aside))))
        few = control.iloc[places[:least]].reset_index(drop=True)
        flights = {
            name: replace(flight, transformation=kind)
            for name, flight in block.flights.items()
        }
        found = es.adjust_block(
            replace(block, control_points=few, **flights), kind=kind
        )
        assert found.failures.empty
        assert len(found.control) == least
        assert not found.control["is_suspect"].any()
        assert found.control["w"].isna().all()
        at_control = found.residuals["point_id"].isin(few["point_id"])
        assert found.residuals.loc[at_control, "is_suspect"].mean() < 0.05


def test_densified_points_are_the_adjusted_ones(result, adjusted):
    ours = result.points.set_index("point_id")
    theirs = adjusted.points.set_index("point_id")
    columns = [*POINTS, "standard_error_total", "covariance_en"]
    pd.testing.assert_frame_equal(ours[columns], theirs.loc[ours.index, columns])
    assert set(ours["role"]) == {"new", "control", "check"}


def test_the_two_step_way_stands_beside_it(block, result):
    plain = es.densify(block)
    beside = result.points.set_index("point_id").loc[plain.points["point_id"]]
    np.testing.assert_array_equal(
        beside[["two_step_easting", "two_step_northing"]], plain.points[POINTS]
    )
    assert result.two_step.figures == plain.figures
    assert result.components == plain.components
    text = summarize(result)
    assert "simultaneous adjustment; " in text.split("\n")[0]
    assert "The two methods differ by" in text.replace("\n    ", " ")


def test_check_points_are_adjusted_as_new_ones(block, result):
    check = block.control_points["role"] == "check"
    moved = block.control_points.copy()
    moved.loc[check, "easting"] += 10.0
    other = es.densify(
        replace(block, control_points=moved), es.Settings(method="simultaneous")
    )
    pd.testing.assert_frame_equal(other.points[POINTS], result.points[POINTS])


def test_control_in_one_corner_holds_the_whole_block(block):
    """In two steps the points beyond the one model with control are lost."""
    control = block.control_points[block.control_points["role"] == "control"]
    along = (control[POINTS] - control[POINTS].mean()).to_numpy() @ [1.0, 1.0]
    few = control.iloc[np.argsort(along)[:4]]
    found = es.densify(
        replace(block, control_points=few, may_be_unmeasured=True),
        es.Settings(method="simultaneous"),
    )
    assert len(found.points) == len(block.truth)
    assert found.points["two_step_easting"].isna().sum() > 10
    truth = block.truth.set_index("point_id").loc[found.points["point_id"], POINTS]
    error = found.points[POINTS].to_numpy() - truth.to_numpy()
    size = np.hypot(*error.T) / found.points["standard_error_total"]
    assert np.sqrt(np.mean(size**2)) < 2.0


def test_a_block_that_two_steps_cannot_do(block, monkeypatch):
    def impossible(*_, **__):
        raise GeometryError("no model of the high flight is usable")

    home = "einschalt.pipeline.densification.one_adjustment.solve_in_two_steps"
    monkeypatch.setattr(home, impossible)
    found = es.densify(block, es.Settings(method="simultaneous"))
    assert found.two_step is None
    assert len(found.points) == len(block.truth)
    said = " ".join(summarize(found).split())
    assert "not possible in this block: no model of the high flight is usable" in said
    assert "not possible" in render(found)


def test_errors_of_unknown_size_give_no_standard_errors(block):
    control = block.control_points.drop(columns="standard_error_m")
    found = es.densify(
        replace(block, control_points=control), es.Settings(method="simultaneous")
    )
    assert "standard_error_total" not in found.points
    said = summarize(found).replace("\n    ", " ")
    assert "No standard errors are given: the control points have no standard" in said
    control = found.simultaneous.control
    assert (control[["difference_easting", "difference_northing"]] == 0.0).all(
        axis=None
    )


def test_residuals_of_control_can_be_distributed(block):
    settings = es.Settings(
        method="simultaneous", residual_distribution="natural_neighbour"
    )
    found = es.densify(block, settings)
    control = found.points[found.points["role"] == "control"].set_index("point_id")
    given = block.control_points.set_index("point_id").loc[control.index, POINTS]
    np.testing.assert_allclose(control[POINTS], given, rtol=0, atol=1e-9)
    assert "standard_error_total" not in found.points
    assert "the propagated one is that after it" not in summarize(found)


def test_names_that_both_flights_use_are_kept_apart(block):
    """Both flights have a model 1/1 of coverage 1, and hold the same points."""
    found = es.adjust_block(block)
    both = found.models.groupby(["coverage", "model_id"])["flight"].nunique()
    assert (both == 2).any()
    renamed = block.high_flight.model_points.assign(
        model_id="h" + block.high_flight.model_points["model_id"]
    )
    other = es.adjust_block(
        replace(block, high_flight=replace(block.high_flight, model_points=renamed))
    )
    np.testing.assert_allclose(
        other.points[POINTS], found.points[POINTS], rtol=0, atol=1e-8
    )


def test_covariances_of_control_are_used(block, adjusted):
    n = len(block.control_points)
    total = block.control_points["standard_error_m"].to_numpy() / np.sqrt(2.0)
    same = with_control(
        block,
        standard_error_easting=total,
        standard_error_northing=total,
        covariance_en=np.zeros(n),
    )
    np.testing.assert_allclose(
        es.adjust_block(same).points[POINTS], adjusted.points[POINTS], rtol=0, atol=1e-9
    )
    unequal = with_control(
        block,
        standard_error_easting=np.full(n, 1e-4),
        standard_error_northing=np.full(n, 10.0),
        covariance_en=np.zeros(n),
    )
    control = es.adjust_block(unequal).control
    assert control["difference_easting"].abs().max() < 1e-3
    assert control["difference_northing"].abs().max() > 0.01


def test_repeated_settings_weigh_more(block):
    low = block.low_flight.model_points
    four = replace(block.low_flight, model_points=low.assign(n_settings=4))
    half = replace(block.low_flight, m_g_um=block.low_flight.m_g_um / 2.0)
    first = es.adjust_block(replace(block, low_flight=four))
    second = es.adjust_block(replace(block, low_flight=half))
    pd.testing.assert_frame_equal(first.points, second.points)


def test_reliability_is_that_of_the_single_coordinate(block, adjusted):
    """MDB = σ δ_0 / √r at 0.1 % and 80 %, and (1 − r) of it stays in the point."""
    sigma = {
        name: flight.m_g_um * 1e-6 * flight.scale_number / np.sqrt(2.0)
        for name, flight in block.flights.items()
    }
    rows = adjusted.residuals
    r = rows["redundancy_number"]
    delta = stats.norm.ppf(1.0 - 0.0005) + stats.norm.ppf(0.80)
    bias = rows["flight"].map(sigma) * delta / np.sqrt(r)
    is_checked = r > 0.01
    np.testing.assert_allclose(
        rows["minimal_detectable_bias"][is_checked], bias[is_checked], rtol=1e-4
    )
    np.testing.assert_allclose(
        rows["external_reliability"][is_checked],
        ((1.0 - r) * bias)[is_checked],
        rtol=1e-4,
    )


def test_two_models_with_one_common_point_and_control_of_their_own(block):
    """Each stands by itself, and the common point is the mean of both."""
    low = block.low_flight.model_points
    truth = block.truth.set_index("point_id")[POINTS]
    first, second = [rows for _, rows in low.groupby(["coverage", "model_id"])][:2]
    common = np.intersect1d(first["point_id"], second["point_id"])
    assert len(common) > 1
    second = second[~second["point_id"].isin(common[1:])]
    apart = [rows[rows["point_id"] != common[0]].head(5) for rows in (first, second)]
    kept = pd.concat(apart)["point_id"].unique()
    control = truth.loc[kept].reset_index().assign(standard_error_m=0.03)
    tables = {
        "both": pd.concat([first, second]),
        "first": first,
        "second": second,
    }
    found = {
        name: simultaneous_adjustment(
            code_block(
                [MeasuredFlight("low_flight", table, np.full(len(table), 0.03), KIND)],
                control,
            )
        )
        for name, table in tables.items()
    }
    assert all(f.failures.empty for f in found.values())
    at = {
        name: f.points.set_index("point_id").loc[common[0]] for name, f in found.items()
    }
    alone = [at["first"], at["second"]]
    weight = [point["standard_error_easting"] ** -2.0 for point in alone]
    mean = np.average(
        [point[POINTS].astype(float) for point in alone], axis=0, weights=weight
    )
    np.testing.assert_allclose(
        at["both"][POINTS].astype(float), mean, rtol=0, atol=1e-8
    )
    assert at["both"]["standard_error_easting"] == pytest.approx(
        sum(weight) ** -0.5, rel=1e-9
    )


@pytest.mark.slow
def test_a_block_that_control_does_not_hold_is_said_to_shrink():
    """Three points in one corner: the other corner is 22 m away, and 8.8 m claimed."""
    block = es.simulate_block("neukirchen", seed=0)
    control = block.control_points.query("role == 'control'")
    xy = control[POINTS].to_numpy()
    corner = np.argsort(np.hypot(*(xy - xy.min(axis=0)).T))[:3]
    few = control.iloc[corner].reset_index(drop=True)
    settings = es.Settings(method="simultaneous")
    found = es.densify(
        replace(block, control_points=few, may_be_unmeasured=True), settings
    )
    text = summarize(found).replace("\n    ", " ")
    assert "Control does not keep the block from shrinking" in text
    assert (
        " times the standard errors, which do not include that. Give control on" in text
    )
    points = found.simultaneous.points
    truth = block.truth.set_index("point_id").loc[points["point_id"], POINTS]
    error = points[POINTS].to_numpy() - truth.to_numpy()
    moved = found.simultaneous.displacements[POINTS].to_numpy()
    claimed = (points["standard_error_total"] ** 2).mean()
    assert (error**2).sum(axis=1).mean() > 4.0 * claimed
    assert ((error - moved) ** 2).sum(axis=1).mean() < claimed
    # nothing checks three points
    assert not found.simultaneous.control["is_suspect"].any()
    whole = es.densify(block, settings)
    assert "its own pull" not in summarize(whole)
    moved = whole.simultaneous.displacements[POINTS].to_numpy()
    assert np.abs(moved).max() < 1e-3


@pytest.mark.slow
@pytest.mark.parametrize("outliers", ["huber", "tukey"])
def test_robust_weights_raise_no_alarm_in_clean_blocks(outliers):
    """Their sum of squares is smaller than that of the errors; s_0 and tests know."""
    s_0, n_suspects = [], 0
    for seed in range(3):
        block = es.simulate_block("neukirchen", seed=seed)
        robust = es.adjust_block(block, outliers=outliers)
        plain = es.adjust_block(block)
        s_0.append(robust.s_0 / plain.s_0)
        n_suspects += int(robust.residuals["is_suspect"].sum())
    np.testing.assert_allclose(s_0, 1.0, atol=0.015)
    # 942 models that have a suspect with a probability of 0.001 each
    assert n_suspects <= 5


@pytest.mark.slow
@pytest.mark.parametrize("outliers", ["snoop", "tukey"])
def test_good_measurements_beside_wrong_control_are_not_blamed(outliers):
    """Three control points are wrong by 1 m, and forty measurements by 50 µm."""
    n_blamed, n_found, n_wrong = 0, 0, 0
    for seed in range(2):
        block = es.simulate_block("neukirchen", seed=seed)
        rng = np.random.default_rng(seed)
        control = block.control_points.copy()
        places = rng.choice(control.index[control["role"] == "control"], 3, False)
        control.loc[places, "easting"] += 1.0
        rows = block.low_flight.model_points.copy()
        wrong = rng.choice(rows.index, 40, replace=False)
        rows.loc[wrong, "x"] += 0.05
        spoilt = replace(
            block,
            control_points=control,
            low_flight=replace(block.low_flight, model_points=rows),
        )
        found = es.adjust_block(spoilt, outliers=outliers)
        named = found.control.query("is_suspect")["point_id"]
        assert set(named) == set(control.loc[places, "point_id"])
        key = ["flight", "coverage", "model_id", "point_id"]
        suspects = set(found.residuals.query("is_suspect")[key].itertuples(index=False))
        true = rows.loc[wrong].assign(flight="low_flight")[key]
        true = set(true.itertuples(index=False))
        n_blamed += len(suspects - true)
        n_found += len(suspects & true)
        n_wrong += len(true)
    assert n_found > 0.9 * n_wrong
    # it was 20 to 30 beside the wrong control alone
    assert n_blamed <= 5
