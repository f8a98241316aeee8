"""Messages in Python name arguments, not options of the command line."""

import pytest

from einschalt.foundations.argument_names import naming_arguments, with_arguments
from einschalt.foundations.errors import BlockError, SettingsError


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("Give a smaller --spacing, or", "Give a smaller spacing, or"),
        ("models (--high-over-low)", "models (high_over_low)"),
        ("Plan with --crs EPSG:31255", "Plan with crs EPSG:31255"),
        ("try it: einschalt simulate --plan FOLDER", None),
        ("worse (simulate --plan).", None),
        ("a -- b, --", None),
    ],
)
def test_options_become_arguments_except_in_commands(text, named):
    assert with_arguments(text) == (named or text)


def test_errors_name_arguments_and_keep_the_rest():
    with pytest.raises(SettingsError) as caught, naming_arguments():
        raise SettingsError("--a-b = 1", expected="2", remedy="See --c", row=3)
    assert str(caught.value) == "row 3: a_b = 1; expected 2. See c."
    with pytest.raises(BlockError) as caught, naming_arguments():
        raise BlockError([SettingsError("--a"), SettingsError("b", remedy="--c d")])
    assert [one.remedy for one in caught.value.problems] == ["", "c d"]
    plain = SettingsError("nothing of it")
    with pytest.raises(SettingsError) as caught, naming_arguments():
        raise plain
    assert caught.value is plain
