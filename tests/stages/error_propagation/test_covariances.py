"""Covariances of points, through the parameters of models and beside them."""

from concurrent.futures import ThreadPoolExecutor
from functools import partial

import numpy as np
import pytest
from scipy import sparse

from einschalt.stages.error_propagation import covariances, propagation_steps
from einschalt.stages.error_propagation.covariances import (
    SharedCovariances,
    covariances_of_pairs,
    propagate,
)
from einschalt.theory.adjustment import bundled_covariance
from einschalt.theory.adjustment.point_operator import (
    Axes,
    PointOperator,
    selection,
    sums,
)

N_MODELS, IN_MODEL, N_SOURCES = 12, 5, 40
N_VALUES = N_MODELS * IN_MODEL
SIZES = {
    "control": np.linspace(0.5, 2.0, N_SOURCES),
    "high_flight": np.ones(N_SOURCES),
    "low_flight": np.linspace(0.1, 0.3, N_VALUES),
    "orientation": np.ones(N_SOURCES),
}
AXES = [Axes.COMPLEX, Axes.PLANE, Axes.SPACE]


def _step(rng, axes, n_rows, n_columns, share=0.3):
    shape = axes.size(n_rows), axes.size(n_columns)
    numbers = rng.normal(size=shape) * (rng.random(shape) < share)
    if axes is Axes.COMPLEX:
        numbers = numbers * (1.0 + 0.5j)
    return PointOperator((sparse.csr_array(numbers),), axes)


def _through_models(rng, axes):
    """Values from the parameters of their models, two points for each model."""
    one = np.ones((IN_MODEL * axes.value, 2 * axes.value))
    where = sparse.block_diag([one] * N_MODELS, format="csr")
    where.data = rng.normal(size=where.nnz)
    return PointOperator((sparse.csr_array(where),), axes)


@pytest.fixture(params=AXES, ids=lambda axes: axes.name)
def chains(request):
    """Errors of two sources pass through parameters; of one beside them as well."""
    rng, axes = np.random.default_rng(1), request.param
    values = _through_models(rng, axes)
    n_parameters = values.n_sources
    onto = _step(rng, axes, n_parameters, 20)
    own = selection(np.arange(N_VALUES), N_VALUES, axes)
    fitted = _step(rng, axes, n_parameters, N_VALUES)
    return {
        "control": values @ onto @ _step(rng, axes, 20, N_SOURCES),
        "high_flight": values @ onto @ _step(rng, axes, 20, N_SOURCES),
        "low_flight": own + values @ fitted,
        "orientation": _step(rng, axes, N_VALUES, N_SOURCES),
    }


def _dense(chains, sizes=SIZES):
    """Covariances between all points from each source, of real coordinates."""
    axes = next(iter(chains.values())).axes
    d, found = len(axes.names), {}
    for name, chain in chains.items():
        columns = []
        for k in range(chain.n_sources * d):
            unit = np.zeros((chain.n_sources, d))
            unit.ravel()[k] = sizes[name][k // d]
            columns.append(chain.of_vectors(unit).ravel())
        rows = np.column_stack(columns)
        n = chain.n_points
        found[name] = (rows @ rows.T).reshape(n, d, n, d).swapaxes(1, 2)
    return found


def _some_pairs():
    return np.stack(np.meshgrid(np.arange(N_VALUES), [0, 5, 7]), -1).reshape(-1, 2)


@pytest.mark.parametrize("pairs", [_some_pairs(), np.array([[3, 50], [50, 3], [7, 7]])])
def test_pairs_of_points(chains, pairs):
    expected = sum(_dense(chains).values())[pairs[:, 0], pairs[:, 1]]
    found = covariances_of_pairs(chains, SIZES, pairs)
    np.testing.assert_allclose(found, expected, atol=1e-10)


@pytest.mark.parametrize("axes", AXES, ids=lambda axes: axes.name)
@pytest.mark.parametrize("is_first", [True, False])
def test_parameters_that_are_a_source_themselves(axes, is_first):
    """As control whose groups share shifts as well: models are fitted onto both."""
    rng = np.random.default_rng(6)
    values = _through_models(rng, axes)
    sizes = {"control": np.linspace(0.5, 1.5, values.n_sources), "groups": np.ones(7)}
    groups = _step(rng, axes, values.n_sources, 7)
    chains = {"control": values, "groups": values @ groups}
    names = list(chains)[:: 1 if is_first else -1]
    chains = {name: chains[name] for name in names}
    pairs = _some_pairs()
    expected = sum(_dense(chains, sizes).values())[pairs[:, 0], pairs[:, 1]]
    found = covariances_of_pairs(chains, sizes, pairs)
    np.testing.assert_allclose(found, expected, atol=1e-10)


def test_every_point_from_each_source(chains, monkeypatch):
    monkeypatch.setattr(covariances, "NUMBERS_OF_RANGE", 1000)  # in ranges of points
    mean = _step(np.random.default_rng(2), chains["control"].axes, 9, N_VALUES)
    to_means = {name: mean @ chain for name, chain in chains.items()}
    names = np.arange(9).astype(str).astype(object)
    errors = propagate(names, to_means, SIZES)
    dense = _dense(to_means)
    for name, part in errors.parts.items():
        own = dense[name][range(9), range(9)]
        np.testing.assert_allclose(part, own, atol=1e-10)
    between = errors.covariance_between(["3", "8"], ["1", "8"])
    whole = sum(dense.values())
    np.testing.assert_allclose(between, whole[[3, 8], [1, 8]], atol=1e-10)


@pytest.mark.parametrize("name", ["control", "low_flight", "orientation"])
def test_one_source_alone(chains, name):
    alone, pairs = {name: chains[name]}, _some_pairs()
    expected = _dense(alone)[name][pairs[:, 0], pairs[:, 1]]
    found = covariances_of_pairs(alone, SIZES, pairs)
    np.testing.assert_allclose(found, expected, atol=1e-10)


@pytest.mark.parametrize("n_models", [2, 4])
@pytest.mark.parametrize("axes", AXES)
def test_points_alone_are_as_among_all_others(axes, n_models):
    """Rows of one point do not tell which numbers belong to a model: all of them."""
    rng, n_values = np.random.default_rng(4), n_models * IN_MODEL
    blocks = [np.ones((IN_MODEL * axes.value, 3 * axes.value))] * n_models
    entries = sparse.block_diag(blocks, format="csr")
    values = _filled(rng, entries, axes)
    fitted = _filled(rng, sparse.csr_array(entries.T), axes)
    # each point is in two models
    both = np.arange(n_values - IN_MODEL)
    places = np.column_stack([both, both + IN_MODEL]).ravel()
    start = 2 * np.arange(len(both) + 1)
    mean = sums(np.full(2 * len(both), 0.5), places, start, n_values, axes)
    chains = {"low_flight": mean @ values @ fitted}
    sizes = {"low_flight": SIZES["low_flight"][:n_values]}
    errors = propagate(both.astype(str).astype(object), chains, sizes)
    np.testing.assert_allclose(
        errors.covariance, _dense(chains)["low_flight"][both, both], atol=1e-9
    )
    for place in both:
        alone = errors.covariance_at(np.array([[place, place]]))
        np.testing.assert_allclose(alone[0], errors.covariance[place], atol=1e-9)


def _filled(rng, pattern, axes):
    entries = pattern.astype(complex if axes is Axes.COMPLEX else float)
    entries.data = rng.normal(size=entries.nnz).astype(entries.dtype)
    return PointOperator((sparse.csr_array(entries),), axes)


@pytest.mark.parametrize("kind", [KeyboardInterrupt, MemoryError])
def test_what_was_interrupted_is_computed_anew(chains, monkeypatch, kind):
    known, pairs = SharedCovariances(), _some_pairs()
    expected = covariances_of_pairs(chains, SIZES, pairs)
    covariances_of_pairs(chains, SIZES, pairs[:1], known)
    joint_covariance, asked = covariances.joint_covariance, []

    def interrupted(*arguments):
        asked.append(arguments)
        if len(asked) == 2:
            raise kind
        return joint_covariance(*arguments)

    monkeypatch.setattr(covariances, "joint_covariance", interrupted)
    with pytest.raises(kind):
        covariances_of_pairs(chains, SIZES, pairs, known)
    found = covariances_of_pairs(chains, SIZES, pairs, known)
    np.testing.assert_allclose(found, expected, atol=1e-10)


@pytest.mark.slow
def test_threads_share_what_is_known(chains):
    every = np.column_stack([np.arange(N_VALUES)] * 2)
    questions = [_some_pairs(), np.array([[10, 59]]), _some_pairs()[:9], every]
    expected = [covariances_of_pairs(chains, SIZES, pairs) for pairs in questions]
    for _ in range(10):
        known = SharedCovariances()
        ask = partial(covariances_of_pairs, chains, SIZES, known=known)
        with ThreadPoolExecutor(8) as pool:
            found = list(pool.map(ask, 8 * questions))
        for one, right in zip(found, 8 * expected, strict=True):
            np.testing.assert_allclose(one, right, atol=1e-10)


def test_other_names_of_the_same_chains_are_other_chains(chains):
    known, pairs = SharedCovariances(), _some_pairs()
    expected = covariances_of_pairs(chains, SIZES, pairs, known)
    named = {f"{name}_2": chain for name, chain in chains.items()}
    sizes = {f"{name}_2": size for name, size in SIZES.items()}
    found = propagate(np.arange(N_VALUES).astype(object), named, sizes, known)
    assert set(found.parts) == set(named)
    again = covariances_of_pairs(named, sizes, pairs, known)
    np.testing.assert_allclose(again, expected, atol=1e-12)


def test_many_pairs_are_taken_in_parts(chains, monkeypatch):
    monkeypatch.setattr(propagation_steps, "PAIRS_AT_ONCE", 10)
    monkeypatch.setattr(bundled_covariance, "PAIRS_AT_ONCE", 10)
    pairs = np.stack(np.meshgrid([3, 9, 20, 41], [3, 9, 20, 41]), -1).reshape(-1, 2)
    expected = sum(_dense(chains).values())[pairs[:, 0], pairs[:, 1]]
    found = covariances_of_pairs(chains, SIZES, pairs)
    np.testing.assert_allclose(found, expected, atol=1e-10)


def test_what_parameters_share_is_computed_once(chains, monkeypatch):
    asked = []
    joint_covariance = covariances.joint_covariance

    def counted(*arguments):
        asked.append(arguments)
        return joint_covariance(*arguments)

    monkeypatch.setattr(covariances, "joint_covariance", counted)
    known, pairs = SharedCovariances(), _some_pairs()
    first = covariances_of_pairs(chains, SIZES, pairs, known)
    assert len(asked) == 3  # sources
    fewer = covariances_of_pairs(chains, SIZES, pairs[:9], known)
    np.testing.assert_allclose(fewer, first[:9], atol=1e-12)
    assert len(asked) == 3
    # pairs of models that did not meet before, and errors of another size
    other = np.array([[10, 59]])
    found = covariances_of_pairs(chains, SIZES, other, known)
    expected = sum(_dense(chains).values())[[10], [59]]
    np.testing.assert_allclose(found, expected, atol=1e-10)
    assert len(asked) == 6
    doubled = {name: 2.0 * size for name, size in SIZES.items()}
    twice = covariances_of_pairs(chains, doubled, other, known)
    np.testing.assert_allclose(twice, 4.0 * found)
    assert len(asked) == 9


def test_a_model_without_numbers_leaves_the_others_alone(chains):
    """An unusable model is NaN, in its own values only."""
    values = chains["control"].factors[0].copy()
    axes = chains["control"].axes
    n_of_model = axes.size(IN_MODEL)
    values.data[values.indptr[:-1][:1][0] : values.indptr[n_of_model]] = np.nan
    bad = {
        name: PointOperator((values, *chains[name].factors[1:]), axes)
        for name in ("control", "high_flight")
    }
    good = {name: chains[name] for name in bad}
    pairs = np.column_stack([np.arange(N_VALUES)] * 2)
    found, expected = (covariances_of_pairs(c, SIZES, pairs) for c in (bad, good))
    assert np.isnan(found[:IN_MODEL]).all()
    np.testing.assert_allclose(found[IN_MODEL:], expected[IN_MODEL:])


def test_errors_that_cancel_each_other_leave_no_variance(chains):
    """The difference of two equal values, by the same and by other parameters."""
    axes = chains["control"].axes
    every = np.arange(N_VALUES)
    both, start = np.tile(every, 2), 2 * np.arange(N_VALUES + 1)
    twice = selection(both, N_VALUES, axes)
    places = np.column_stack([every, every + N_VALUES]).ravel()
    signs = np.tile([1.0, -1.0], N_VALUES)
    apart = sums(signs, places, start, 2 * N_VALUES, axes)
    copies = {
        # not multiplied, as values of two models: only their sum cancels
        name: PointOperator.sum_of(
            PointOperator(
                (apart.matrix, (twice @ one).last_step.matrix, *one.factors), axes
            )
            for one in chain.products
        )
        for name, chain in chains.items()
    }
    whole = propagate(every.astype(object), chains, SIZES).covariance
    found = propagate(every.astype(object), copies, SIZES).covariance
    assert np.trace(whole, axis1=1, axis2=2).min() > 1.0
    assert not found.any()


def test_no_points_have_no_covariances(chains):
    none = selection([], N_VALUES, chains["control"].axes)
    chains = {name: none @ chain for name, chain in chains.items()}
    parts = propagate([], chains, SIZES).parts
    assert {len(part) for part in parts.values()} == {0}
