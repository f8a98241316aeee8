"""Affine and helmert against statsmodels, on fifty weighted models of 4 to 60 points.

Ground coordinates are of 5·10⁶ m. The design that statsmodels gets is centred: an
uncentred one at that distance is nearly singular, and a solution by singular values
(numpy's lstsq, statsmodels' pinv) cuts off or loses digits norm-wise over columns of
1 and of 5·10⁶. Its s_0 was wrong by up to 135 %; the last test shows it. Parameters
are the same after the shift is carried to the common origin; residuals, s_0,
leverages and the rest do not know the origin at all.
"""

import numpy as np
import pandas as pd
import pytest
import statsmodels.api as sm

import einschalt as es

N_MODELS = 50
TIGHT = {"rtol": 1e-9, "atol": 0}


def models(kind, *, offset=(0.0, 0.0), seed=71):
    """Fifty models at 1:8000, noise 0.3 m, weights 0.5 to 2."""
    rng = np.random.default_rng(seed)
    for number in range(N_MODELS):
        n = int(rng.integers(4, 61))
        x, y = xy = rng.uniform(-400.0, 400.0, (2, n))
        angle = rng.uniform(-np.pi, np.pi)
        c, s = 2.5 * np.cos(angle), 2.5 * np.sin(angle)
        shear = 0.01 if kind == "affine" else 0.0
        east = c * x - s * y + shear * y + rng.normal(0.0, 0.3, n)
        north = s * x + c * y + rng.normal(0.0, 0.3, n)
        origin = np.array([4.5e6, 5.3e6]) + rng.uniform(-5e4, 5e4, 2)
        en = np.column_stack([east, north]) + origin
        yield number, xy.T + offset, en, rng.uniform(0.5, 2.0, n)


def tables(kind, **options):
    model_parts, ground_parts = [], []
    for number, xy, en, weights in models(kind, **options):
        names = [f"{number}-{place}" for place in range(len(xy))]
        ids = {"model_id": str(number), "point_id": names, "weight": weights}
        model_parts.append(pd.DataFrame(xy, columns=["x", "y"]).assign(**ids))
        ground = pd.DataFrame(en, columns=["easting", "northing"])
        ground_parts.append(ground.assign(point_id=names))
    return (
        pd.concat(model_parts, ignore_index=True),
        pd.concat(ground_parts, ignore_index=True),
    )


def design(kind, xy):
    """Rows of the eastings, then of the northings, in our order of parameters."""
    x, y = xy.T
    one, zero = np.ones_like(x), np.zeros_like(x)
    if kind == "helmert":
        east = np.column_stack([x, -y, one, zero])
        north = np.column_stack([y, x, zero, one])
    else:
        nothing = np.zeros((len(x), 3))
        east = np.column_stack([one, x, y, nothing])
        north = np.column_stack([nothing, one, x, y])
    return np.vstack([east, north])


def by_statsmodels(kind, xy, en, weights):
    """Fit with the centred design, and influence from the whitened rows."""
    observed = (en - en[0]).T.ravel()
    matrix = design(kind, xy - xy.mean(axis=0))
    fit = sm.WLS(observed, matrix, weights=np.tile(weights, 2)).fit()
    root = np.sqrt(np.tile(weights, 2))
    white = sm.OLS(observed * root, matrix * root[:, None]).fit()
    return fit, white.get_influence()


def to_centroid(kind, centre):
    """Derivative of the parameters about the centroid by those about the origin."""
    matrix = np.eye(4 if kind == "helmert" else 6)
    x, y = centre
    if kind == "helmert":
        matrix[2, :2], matrix[3, :2] = [x, -y], [y, x]
    else:
        matrix[0, 1:3] = matrix[3, 4:6] = [x, y]
    return matrix


@pytest.fixture(scope="module", params=["affine", "helmert"])
def compared(request):
    kind = request.param
    fit = es.transform_models(*tables(kind), kind=kind)
    theirs = [by_statsmodels(kind, *parts[1:]) for parts in models(kind)]
    return kind, fit, theirs


def test_parameters_and_covariance(compared):
    kind, fit, theirs = compared
    shifts = [0, 3] if kind == "affine" else [2, 3]
    for (number, xy, en, _), (other, _) in zip(models(kind), theirs, strict=True):
        step = to_centroid(kind, xy.mean(axis=0))
        found = step @ fit.parameters.loc[str(number)].to_numpy()
        found[shifts] -= en[0]
        # 1e-9 m is one unit in the last place of the shift itself
        np.testing.assert_allclose(found, other.params, rtol=1e-9, atol=3e-9)
        covariance = step @ fit.covariance(str(number)).to_numpy() @ step.T
        size = np.sqrt(np.diag(other.cov_params()))
        wrong = (covariance - other.cov_params()) / np.outer(size, size)
        assert np.abs(wrong).max() < 1e-9


def test_standard_error_and_redundancy(compared):
    _, fit, theirs = compared
    s_0 = np.sqrt([other.scale for other, _ in theirs])
    np.testing.assert_allclose(fit.models["s_0"], s_0, **TIGHT)
    assert fit.models["redundancy"].tolist() == [o.df_resid for o, _ in theirs]


def test_residuals_and_leverage(compared):
    kind, fit, theirs = compared
    for number, (other, influence) in enumerate(theirs):
        rows = fit.residuals[fit.residuals["model_id"] == str(number)]
        found = rows[["residual_easting", "residual_northing"]].to_numpy()
        # ours are transformed − given
        wanted = -other.resid.reshape(2, -1).T
        np.testing.assert_allclose(found, wanted, rtol=1e-9, atol=1e-9)
        leverage = influence.hat_matrix_diag.reshape(2, -1).T
        np.testing.assert_allclose(
            rows["leverage"], leverage.mean(axis=1), **TIGHT, err_msg=kind
        )


def test_studentised_residuals(compared):
    _, fit, theirs = compared
    s_0 = fit.models.set_index("model_id")["s_0"]
    # no point lacks a partner: the residuals stand in the order of the input
    residuals = fit.residuals.assign(weight=tables(fit.kind)[0]["weight"])
    for number, (_, influence) in enumerate(theirs):
        rows = residuals[residuals["model_id"] == str(number)]
        part = rows["redundancy_number"] / rows["weight"]
        found = rows["residual_easting"] / (s_0[str(number)] * np.sqrt(part))
        wanted = -influence.resid_studentized_internal[: len(rows)]
        np.testing.assert_allclose(found, wanted, rtol=1e-7, atol=1e-8)


FAR = (4.4e6, 5.2e6)


@pytest.mark.parametrize("kind", ["affine", "helmert"])
def test_both_frames_far_away(kind):
    fit = es.transform_models(*tables(kind, offset=FAR), kind=kind)
    theirs = [by_statsmodels(kind, *parts[1:]) for parts in models(kind, offset=FAR)]
    s_0 = np.sqrt([other.scale for other, _ in theirs])
    # rounding of the coordinates, 1e-9 of 0.3 m
    np.testing.assert_allclose(fit.models["s_0"], s_0, rtol=3e-9)
    leverage = np.concatenate(
        [i.hat_matrix_diag.reshape(2, -1).mean(axis=0) for _, i in theirs]
    )
    np.testing.assert_allclose(fit.residuals["leverage"], leverage, rtol=1e-9)


def test_uncentred_solution_loses_digits():
    fit = es.transform_models(*tables("helmert", offset=FAR), kind="helmert")
    centred, uncentred = [], []
    for _, xy, en, weights in models("helmert", offset=FAR):
        other, _ = by_statsmodels("helmert", xy, en, weights)
        centred.append(np.sqrt(other.scale))
        root = np.sqrt(np.tile(weights, 2))
        matrix = design("helmert", xy) * root[:, None]
        observed = en.T.ravel() * root
        parameters, *_ = np.linalg.lstsq(matrix, observed)
        squares = np.sum((matrix @ parameters - observed) ** 2)
        uncentred.append(np.sqrt(squares / other.df_resid))
    ours = np.abs(fit.models["s_0"] / centred - 1.0)
    theirs = np.abs(np.array(uncentred) / centred - 1.0)
    assert ours.max() < 3e-9
    assert np.median(theirs) > 1e3 * np.median(ours)
    assert theirs.max() > 1e-5
