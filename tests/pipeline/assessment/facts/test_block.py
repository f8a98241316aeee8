from dataclasses import replace

from tests.changed_results import changed

from einschalt.pipeline.assessment.facts.block import block_facts
from einschalt.pipeline.settings import Settings


def test_models_of_all_flights_are_counted_and_those_that_failed(faulty_result):
    facts = block_facts(faulty_result.examination)
    measured = [
        len(flight.model_points[["coverage", "model_id"]].drop_duplicates())
        for flight in faulty_result.block.flights.values()
    ]
    assert facts.n_models == sum(measured) == 30
    assert facts.n_failed_models == 3


def test_a_model_that_failed_at_two_stages_is_one(faulty_result):
    twice = faulty_result.failures
    twice = twice.loc[[*twice.index, *twice.index]].reset_index(drop=True)
    result = changed(faulty_result, failures=twice)
    assert block_facts(result.examination).n_failed_models == 3


def test_only_settings_that_differ_are_named(good_result):
    facts = block_facts(good_result.examination)
    assert facts.chosen_settings == ()
    assert (facts.n_failed_models, facts.crs) == (0, good_result.block.crs)
    settings = Settings(coverage_mean="most_central", outliers="snoop")
    facts = block_facts(changed(good_result, settings=settings).examination)
    assert set(facts.chosen_settings) == {
        ("coverage_mean", "most_central"),
        ("outliers", "snoop"),
    }


def test_the_name_is_that_of_the_block(good_result):
    block = replace(good_result.block, name="Tal")
    assert block_facts(changed(good_result, block=block).examination).name == "Tal"
