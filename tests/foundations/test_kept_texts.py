"""Texts that were kept in English, told in the language of the reader."""

import pytest

from einschalt.foundations.kept_texts import retold
from einschalt.foundations.language import written_in


@pytest.mark.parametrize("name", ["0012", "10234", "20240512"])
@pytest.mark.parametrize(
    "text",
    [
        "there is no {}",
        "photo {} is not among the 55 photos",
        "the system {} is unknown",
    ],
)
def test_names_of_digits_stay_as_they_are_given(text, name):
    with written_in("de"):
        told = retold(text.format(name))
    assert told != text.format(name)
    assert name in told
