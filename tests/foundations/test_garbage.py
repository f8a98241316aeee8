"""What is looked over for garbage, and when."""

import gc

import pytest

from einschalt.foundations.garbage import (
    RUBBISH_WORTH_A_LOOK,
    clear_garbage,
    made_for_good,
)


@pytest.fixture(autouse=True)
def given_settings():
    """As they were: nothing is taken for good meanwhile, as the whole run does."""
    threshold, n_frozen = gc.get_threshold(), gc.get_freeze_count()
    gc.unfreeze()
    yield
    gc.unfreeze()
    if n_frozen:
        gc.collect()
        gc.freeze()
    gc.set_threshold(*threshold)
    assert gc.isenabled()


def test_nothing_is_looked_for_meanwhile_nor_often_afterwards():
    with made_for_good():
        assert not gc.isenabled()
        kept = [[k] for k in range(100)]
    assert gc.isenabled()
    assert gc.get_threshold()[0] == RUBBISH_WORTH_A_LOOK
    assert gc.get_freeze_count() > len(kept)


def test_it_is_looked_for_again_after_a_failure():
    with pytest.raises(ValueError, match="no module"), made_for_good():
        raise ValueError("no module")
    assert gc.isenabled()
    assert gc.get_freeze_count() == 0


@pytest.mark.slow
def test_what_holds_itself_is_cleared():
    gone = []

    class Held:
        def __init__(self):
            self.own = self

        def __del__(self):
            gone.append(True)

    kept = [[k] for k in range(100_000)]
    for for_good in (False, True):
        Held()
        assert not gone
        clear_garbage(for_good=for_good)
        assert gone.pop()
        assert len(gc.get_objects()) < len(kept) or not for_good
