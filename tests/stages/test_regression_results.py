"""Models as statsmodels sees them: the same numbers, and its diagnostics work."""

import subprocess
import sys
import warnings

import numpy as np
import pandas as pd
import pytest
import statsmodels.api as sm
from statsmodels.stats.outliers_influence import OLSInfluence

import einschalt as es
from einschalt.foundations.errors import GeometryError, SettingsError, TableError
from einschalt.foundations.rotations import rotation_from_angles
from einschalt.stages.model_screening import screen_models
from einschalt.stages.regression_results import regression_of_flight

KINDS = ["affine", "helmert", "rigid", "helmert_3d"]
GROUND = ["easting", "northing", "height"]
ORIGIN = np.array([4.5e6, 5.3e6, 450.0])
TIGHT = {"rtol": 1e-9, "atol": 0.0}
# half a unit in the last place of 5.3·10⁶ m, in both computations
LAST_DIGIT = 2e-9
N_MODELS = 8


@pytest.fixture(autouse=True)
def _no_warnings():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        yield


def tables(kind, *, gross=0.0, far=0.0, noise=0.05):
    """Eight models of 7 to 28 points at 5·10⁶ m, noise in metres, weights 0.5 to 2."""
    rng = np.random.default_rng(41)
    models, grounds = [], []
    for number in range(N_MODELS):
        n = 7 + 3 * number
        enh = rng.uniform(-1.0, 1.0, (n, 3)) * [900.0, 600.0, 80.0]
        angles = [*rng.normal(0.0, 0.05, 2), rng.uniform(-3.0, 3.0)]
        if kind != "helmert_3d":
            angles[:2] = 0.0, 0.0
        scale = 1.0 if kind == "rigid" else 0.4
        xyz = scale * enh @ rotation_from_angles(*angles).T + far
        ground = enh + ORIGIN + rng.normal(0.0, noise, enh.shape)
        ground[2, 0] += gross
        names = [f"{number}-{place}" for place in range(n)]
        ids = {"model_id": f"m{number}", "point_id": names}
        models.append(pd.DataFrame(xyz, columns=["x", "y", "z"]).assign(**ids))
        grounds.append(pd.DataFrame(ground, columns=GROUND).assign(point_id=names))
    model = pd.concat(models, ignore_index=True)
    weight = rng.uniform(0.5, 2.0, len(model))
    return model.assign(weight=weight), pd.concat(grounds, ignore_index=True)


@pytest.fixture(scope="module", params=KINDS)
def fitted(request):
    return es.transform_models(*tables(request.param), kind=request.param)


def own_rows(fit, row):
    return slice(*fit.observed.start[row : row + 2])


def assert_same(fit, theirs, row):
    model_id = fit.models["model_id"].iloc[row]
    own = own_rows(fit, row)
    ours = fit.parameters.loc[model_id]
    covariance = fit.covariance(model_id)
    size = np.sqrt(np.diag(covariance))
    assert list(theirs.params.index) == list(ours.index) == theirs.model.exog_names
    np.testing.assert_allclose(theirs.params_at_origin, ours, **TIGHT)
    wrong = (theirs.cov_params_at_origin - covariance) / np.outer(size, size)
    assert np.abs(wrong.to_numpy()).max() < 1e-9
    # shifts differ from ours by where they are; what else there is does not
    rest = theirs.params.index[~theirs.params.index.str.match("t[enh]$|[ab]0$")]
    np.testing.assert_allclose(theirs.params[rest], ours[rest], **TIGHT)
    errors = pd.Series(size, ours.index)
    np.testing.assert_allclose(theirs.bse[rest], errors[rest], **TIGHT)
    np.testing.assert_allclose(np.sqrt(theirs.scale), fit.fit.s_0[row], **TIGHT)
    assert theirs.df_resid == fit.fit.redundancy[row]
    residuals = fit.fit.residuals[own].T.ravel()
    np.testing.assert_allclose(-theirs.resid, residuals, rtol=1e-9, atol=LAST_DIGIT)
    leverage = theirs.get_influence().hat_matrix_diag
    np.testing.assert_allclose(leverage, fit.fit.leverage[own].T.ravel(), **TIGHT)


@pytest.mark.parametrize("row", range(N_MODELS))
def test_every_model_of_every_kind_is_ours(fitted, row):
    assert_same(fitted, fitted.to_statsmodels(f"m{row}"), row)


@pytest.mark.parametrize("kind", ["affine", "helmert", "helmert_3d"])
def test_models_whose_own_origin_is_far_away(kind):
    fit = es.transform_models(*tables(kind, far=5e5), kind=kind)
    assert_same(fit, fit.to_statsmodels("m3"), 3)


# with hundredths of a millimetre, variances in m² are smaller than usual tolerances
@pytest.mark.parametrize("noise", [0.05, 5e-5])
@pytest.mark.parametrize("outliers", ["snoop", "huber", "tukey"])
def test_models_with_gross_errors(outliers, noise):
    fit = es.transform_models(*tables("affine", gross=100.0 * noise, noise=noise))
    screened = screen_models(fit, outliers)
    theirs = screened.to_statsmodels("m5")
    assert_same(screened, theirs, 5)
    n_points = screened.models["n_points"].iloc[5]
    assert theirs.nobs == 2 * n_points == 2 * (21 if outliers == "snoop" else 22)
    # the scale of a robust fit is that of good points, not of weighted squares
    assert (theirs.cov_type == "fixed scale") == (outliers != "snoop")
    assert theirs.use_t


def test_equations_bear_the_names_of_coordinates_and_points(fitted):
    theirs = fitted.to_statsmodels("m1")
    axes = GROUND if fitted.kind == "helmert_3d" else GROUND[:2]
    assert theirs.resid.index.names == ["coordinate", "point_id"]
    assert list(theirs.resid.index.unique("coordinate")) == axes
    rows = fitted.residuals[fitted.residuals["model_id"] == "m1"]
    by_point = rows.set_index("point_id")["residual_easting"]
    found = -theirs.resid["easting"]
    assert list(found.index) == list(by_point.index)
    np.testing.assert_allclose(found, by_point, rtol=1e-9, atol=LAST_DIGIT)


def test_shifts_are_those_of_the_weighted_centroid(fitted):
    theirs = fitted.to_statsmodels("m2")
    own = own_rows(fitted, 2)
    weights = fitted.observed.weights[own]
    mean = np.average(fitted.observed.source[own], axis=0, weights=weights)
    np.testing.assert_allclose(theirs.centroid_model, mean, rtol=0, atol=1e-9)
    shifts = theirs.params[theirs.params.index.str.match("t[enh]$|[ab]0$")]
    assert len(shifts) == len(theirs.centroid_ground) == len(mean)
    assert shifts.abs().max() < LAST_DIGIT
    expected = fitted.fit.s_0[2] / np.sqrt(weights.sum())
    np.testing.assert_allclose(theirs.bse[shifts.index], expected, **TIGHT)


def test_linearisation_is_that_of_finite_differences():
    # of the spatial model: angles by small steps of the whole transformation
    fit = es.transform_models(*tables("helmert_3d"), kind="helmert_3d")
    theirs, own = fit.to_statsmodels("m4"), own_rows(fit, 4)
    d = fit.observed.source[own] - theirs.centroid_model.to_numpy()

    def ground(p):
        rotation = rotation_from_angles(p["omega"], p["phi"], p["kappa"]).T
        return p["scale"] * d @ rotation.T + p[["te", "tn", "th"]].to_numpy()

    step = 1e-6
    for name in theirs.params.index:
        there, back = theirs.params.copy(), theirs.params.copy()
        there[name] += step
        back[name] -= step
        slope = (ground(there) - ground(back)).T.ravel() / (2.0 * step)
        np.testing.assert_allclose(theirs.model.data.orig_exog[name], slope, atol=1e-6)


def test_influence_is_that_of_the_weighted_equations():
    fit = es.transform_models(*tables("affine"))
    theirs = fit.to_statsmodels("m0")
    root = np.sqrt(theirs.model.weights)
    whitened = sm.OLS(theirs.model.endog * root, theirs.model.exog * root[:, None])
    expected, found = OLSInfluence(whitened.fit()), theirs.get_influence()
    for name in ("resid_studentized_internal", "resid_studentized_external", "dfbetas"):
        np.testing.assert_allclose(
            getattr(found, name), getattr(expected, name), rtol=1e-9, atol=1e-12
        )
    frame = found.summary_frame()
    assert list(frame.index) == list(theirs.resid.index)
    assert {"dfb_a1", "cooks_d", "hat_diag"} <= set(frame.columns)
    # what one equation is worth: without it, the parameters move by dfbeta
    n = len(root)
    fewer = sm.WLS(
        theirs.model.endog[1:], theirs.model.exog[1:], theirs.model.weights[1:]
    )
    moved = theirs.params.to_numpy() - fewer.fit().params
    np.testing.assert_allclose(found.dfbeta[0], moved, rtol=1e-7, atol=1e-12)
    assert found.hat_matrix_diag.sum() == pytest.approx(n - theirs.df_resid)


def test_hypotheses_are_tested_by_name():
    # affine models that are a similarity, and helmert models that are no rigid ones
    affine = es.transform_models(*tables("affine")).to_statsmodels("m6")
    assert affine.f_test("a1 = b2, a2 = -b1").pvalue > 0.001
    helmert = es.transform_models(*tables("helmert"), kind="helmert")
    assert helmert.to_statsmodels("m6").t_test("te = 0").pvalue > 0.5
    assert "te" in str(helmert.to_statsmodels("m6").summary())


def test_a_robust_covariance_can_be_asked_for_afterwards():
    theirs = es.transform_models(*tables("helmert"), kind="helmert").to_statsmodels(
        "m7"
    )
    robust = theirs.get_robustcov_results("HC3")
    assert robust.cov_type == "HC3"
    np.testing.assert_array_equal(robust.params, theirs.params)


def test_a_model_without_redundancy_has_parameters_and_no_errors():
    model, ground = tables("affine")
    fit = es.transform_models(model.groupby("model_id").head(3), ground)
    theirs = fit.to_statsmodels("m0")
    np.testing.assert_allclose(theirs.params_at_origin, fit.parameters.loc["m0"])
    assert theirs.df_resid == 0
    assert theirs.bse.isna().all()


def test_models_that_failed_say_why():
    model, ground = tables("affine")
    few = model["model_id"].eq("m1") & model.index.isin(
        model.groupby("model_id").tail(-2).index
    )
    fit = es.transform_models(model[~few], ground)
    with pytest.raises(GeometryError, match="model m1: it has no transformation: 2 co"):
        fit.to_statsmodels("m1")
    with pytest.raises(GeometryError, match="Transform with helmert"):
        fit.to_statsmodels("m1")


def test_unknown_and_ambiguous_models_are_refused():
    model, ground = tables("affine")
    both = pd.concat([model.assign(coverage="1"), model.assign(coverage="2")])
    fit = es.transform_models(both, ground)
    with pytest.raises(TableError, match="no such model"):
        fit.to_statsmodels("m99")
    with pytest.raises(TableError, match="Name the coverage"):
        fit.to_statsmodels("m1")
    second = fit.to_statsmodels("m1", coverage="2").params
    alone = es.transform_models(model, ground).to_statsmodels("m1").params
    np.testing.assert_array_equal(second, alone)


def test_a_spatial_model_on_edge_has_no_angles():
    model, ground = tables("helmert_3d")
    one = model[model["model_id"] == "m0"].reset_index(drop=True)
    enh = ground[ground["point_id"].isin(one["point_id"])][GROUND].to_numpy() - ORIGIN
    one[["x", "y", "z"]] = enh @ rotation_from_angles(0.0, np.pi / 2, 0.3).T
    fit = es.transform_models(one, ground, kind="helmert_3d")
    with pytest.raises(GeometryError, match="phi is a right angle"):
        fit.to_statsmodels("m0")


@pytest.mark.parametrize("flight", ["low_flight", "high_flight"])
def test_models_of_both_flights_of_a_block(good_result, flight):
    steps = good_result.solution
    fit = steps.low if flight == "low_flight" else steps.high.transformation
    model = fit.models.iloc[0]
    theirs = good_result.to_statsmodels(
        model["model_id"], model["coverage"], flight=flight
    )
    ours = fit.parameters.iloc[0]
    np.testing.assert_allclose(theirs.params_at_origin, ours, **TIGHT)


def test_flights_that_there_are_not_are_refused(good_result):
    with pytest.raises(SettingsError, match="flight"):
        good_result.to_statsmodels("1", flight="third")
    with pytest.raises(GeometryError, match="no model of the high flight"):
        regression_of_flight(None, good_result.solution.low, "1", flight="high_flight")
    with pytest.raises(GeometryError, match="no model of the low flight"):
        regression_of_flight(None, None, "1")


@pytest.mark.slow
def test_nobody_imports_statsmodels_who_does_not_ask_for_it():
    # nor matplotlib: reports draw their pictures themselves
    code = (
        "import sys; import einschalt as es; es.densify, es.transform_models; "
        "import einschalt.interfaces.cli.densify; "
        "import einschalt.interfaces.cli.work.densify; "
        "heavy = {'statsmodels', 'scipy.stats', 'matplotlib', 'geopandas'}; "
        "print(heavy & set(sys.modules))"
    )
    shown = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    assert shown.stdout.strip() == "set()"
