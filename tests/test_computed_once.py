"""One ``einschalt densify`` computes everything once, however often it is looked at.

Report, summary and tolerance look at the same tests, figures and patterns.
"""

import sys
from collections import Counter
from dataclasses import replace
from functools import wraps

import pytest
from tests.photographs_onto_control import one_flight

import einschalt as es
from einschalt.interfaces.cli.work.densify import densify
from einschalt.interfaces.reports import html_report  # noqa: F401  its names are counted
from einschalt.pipeline.assessment import assess
from einschalt.pipeline.assessment.evidence import (
    claim,
    exchanged_names,
    leave_one_out,
    repeated_settings,
    systematic_errors,
    variance_components,
)
from einschalt.pipeline.assessment.findings import catalogue, orientations
from einschalt.pipeline.densification import (
    gross_errors,
    iteration,
    low_flight_fit,
    simultaneous,
)
from einschalt.pipeline.simulation.simulate_block import PRESETS
from einschalt.stages.error_propagation.error_model import ErrorModel
from einschalt.stages.simultaneous import adjustment

pytestmark = pytest.mark.slow

EVIDENCE = (
    (claim, "examine_claim"),
    (exchanged_names, "find_exchanged_names"),
    (leave_one_out, "leave_out_control"),
    (variance_components, "estimate_components"),
    (systematic_errors, "find_patterns"),
    (repeated_settings, "m_g_of_repeated_settings"),
)
JUDGED = (
    (assess, "assess"),
    (catalogue, "findings_of"),
    (low_flight_fit, "transform_low_flight"),
)


@pytest.fixture
def counted(monkeypatch):
    """Calls of functions by name, from whatever module they are called."""
    calls = Counter()

    def count(home, name, key=lambda *_, **__: ()):
        function = getattr(home, name)

        @wraps(function)
        def counting(*arguments, **options):
            calls[(name, *key(*arguments, **options))] += 1
            return function(*arguments, **options)

        modules = [m for n, m in sys.modules.items() if n.startswith("einschalt")]
        for module in (home, *modules):
            if vars(module).get(name) is function:
                monkeypatch.setattr(module, name, counting)

    count.calls = calls
    return count


def densified(block, folder, **settings):
    """Densify as the command does: report, summary, tolerance."""
    block.write(folder / "block")
    given = {"tolerance": "vermv_2016", **settings}
    densify(folder / "block", folder / "out", given)
    assert (folder / "out" / "report.html").exists()
    assert (folder / "out" / "summary.txt").exists()


def test_two_steps_are_examined_once(tmp_path, counted, capsys):
    block = es.simulate_block("demo", seed=1)
    lengths = [test.name for test in es.densify(block).claim.tests if test.is_length]
    assert len(lengths) >= 4
    for home, name in (*EVIDENCE, *JUDGED):
        counted(home, name)
    counted(ErrorModel, "draw")
    # each test of the claim by its name
    counted(claim, "_test_of_size", key=lambda name, *_: (name,))
    densified(block, tmp_path)
    once = [(name,) for _, name in (*EVIDENCE, *JUDGED)]
    once += [("draw",), *(("_test_of_size", name) for name in lengths)]
    assert counted.calls == Counter(once)
    assert "Tolerance" in capsys.readouterr().out


def test_orientations_are_doubted_by_one_refit_of_each_flight(tmp_path, counted):
    geometry = replace(PRESETS["demo"].geometry, measurement="parallaxes")
    block = es.simulate_block("demo", seed=1, geometry=geometry)
    for home, name in EVIDENCE:
        counted(home, name)
    refits = []
    refit = orientations.transform_models

    def counting(points, *arguments):
        refits.append(len(points))
        return refit(points, *arguments)

    orientations.transform_models = counting
    try:
        densified(block, tmp_path)
    finally:
        orientations.transform_models = refit
    assert refits == [len(f.points_to_fit) for f in block.flights.values()]
    assert {name for name, *_ in counted.calls} >= {"examine_claim", "find_patterns"}
    assert set(counted.calls.values()) == {1}, counted.calls


def test_one_adjustment_and_the_two_steps_beside_it_are_examined_once(
    tmp_path, counted
):
    for home, name in (*EVIDENCE, *JUDGED, (simultaneous, "adjust_flights")):
        counted(home, name)
    counted(ErrorModel, "draw")
    densified(es.simulate_block("demo", seed=1), tmp_path, method="simultaneous")
    once = {"estimate_components", "find_patterns", "adjust_flights", "assess"}
    assert {name for name, *_ in counted.calls} >= once
    assert set(counted.calls.values()) == {1}, counted.calls


@pytest.mark.parametrize("method", ["two_step", "simultaneous"])
def test_gross_measurements_that_take_part_are_looked_for_once(counted, method):
    """Those that are told are those without which the block is computed again."""
    block = es.simulate_block("demo", seed=2)
    points = block.low_flight.model_points.copy()
    points.loc[points.index[20], "x"] += 0.4
    block = replace(block, low_flight=replace(block.low_flight, model_points=points))
    counted(gross_errors, "_refused", key=lambda searched, _: (*searched.flights,))
    result = es.densify(block, es.Settings(method=method, outliers="keep"))
    codes = [found.code for found in result.assessment.findings]
    assert codes[0] == "kept_gross_measurements"
    once = [("_refused", name) for name in block.flights]
    assert counted.calls == Counter(once)


@pytest.mark.parametrize(
    ("method", "outliers"),
    [("two_step", "snoop"), ("simultaneous", "snoop"), ("auto", "huber")],
)
def test_gross_errors_of_one_flight_are_searched_once(counted, method, outliers):
    """The two steps and one adjustment of all models ask for the same search."""
    block = one_flight(seed=2)
    counted(adjustment, "weigh_part")
    counted(simultaneous, "simultaneous_adjustment")
    result = es.densify(block, es.Settings(method=method, outliers=outliers))
    assert result.assessment.findings
    # in two steps it is tried whether one adjustment is better
    assert counted.calls[("simultaneous_adjustment",)] == 2
    assert counted.calls[("weigh_part",)] == 1


def test_tables_are_coded_once_and_not_kept_of_a_large_block(counted, monkeypatch):
    """For what bends models, and for the adjustment that is tried."""
    block = es.simulate_block("demo", seed=1)
    counted(simultaneous, "block_tables")
    result = es.densify(block)
    points = result.assessment.better, result.points
    assert counted.calls == {("block_tables",): 1}
    assert result.solution.searched is not None
    monkeypatch.setattr(gross_errors, "MOST_KEPT", 0)
    large = es.densify(block)
    assert large.solution.searched is None
    assert large.assessment.better == points[0]
    assert large.points.equals(points[1])
    assert counted.calls == {("block_tables",): 3}


def test_iterations_propagate_the_first_pass_once_more(tmp_path, counted):
    for home, name in EVIDENCE:
        counted(home, name)
    counted(iteration, "iterate")
    counted(ErrorModel, "draw")
    densified(es.simulate_block("demo", seed=1), tmp_path, iterations=3)
    assert counted.calls[("iterate",)] == 1
    assert counted.calls[("draw",)] == 1
    assert set(counted.calls.values()) == {1}, counted.calls


@pytest.fixture(scope="module")
def blundered():
    """A spatial block with gross errors."""
    geometry = replace(PRESETS["demo"].geometry, transformation="helmert_3d")
    noise = es.BlockNoise(high_gross_error_share=0.03, low_gross_error_share=0.03)
    return es.simulate_block("demo", seed=1, geometry=geometry, noise=noise)


@pytest.mark.parametrize("outliers", ["keep", "huber"])
def test_what_bends_models_is_estimated_once(blundered, counted, outliers):
    counted(simultaneous, "estimate_for")
    counted(simultaneous, "adjust_flights")
    result = es.densify(blundered, es.Settings(outliers=outliers))
    assert result.assessment.findings
    assert counted.calls == {
        ("estimate_for",): 1,
        ("adjust_flights",): 1,  # heights of control are tested by it, or it is tried
    }


@pytest.mark.parametrize("kind", ["helmert", "helmert_3d"])
def test_a_robust_adjustment_knows_what_is_lost_without_gross_errors(blundered, kind):
    geometry = replace(blundered.geometry, transformation=kind)
    noise = replace(blundered.noise, low_gross_error_um=20_000.0)
    block = es.simulate_block("demo", seed=3, geometry=geometry, noise=noise)
    robust, snooped = (
        es.densify(block, es.Settings(method="simultaneous", outliers=outliers))
        for outliers in ("huber", "snoop")
    )
    assert robust.simultaneous.loses_no_others
    names = [set(r.simultaneous.failures["model_id"]) for r in (robust, snooped)]
    assert names[0] == names[1]
