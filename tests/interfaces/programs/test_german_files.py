"""What is said of other programs' files, in German: damage, and notes of reading."""

import re

import pytest
from fuzz.foreign_files import READ
from tests.interfaces.programs.test_recognised import DAMAGED, read_foreign
from tests.pipeline.summary.test_german_summary import ENGLISH

from einschalt.foundations.errors import EinschaltError
from einschalt.foundations.kept_texts import retold
from einschalt.foundations.language import written_in
from einschalt.foundations.told_errors import told

MORE_ENGLISH = re.compile(rf"{ENGLISH.pattern}|\b(has|holds|each|no|not|line)\b")
# what stands in the file, its name, and what the library for XML says
DATA = re.compile(r"'.*?'|„.*?“|\S+\.points|no element found")


def english_in(text):
    return [found[0] for found in MORE_ENGLISH.finditer(DATA.sub("", text))]


@pytest.mark.parametrize(("name", "text"), [one[:2] for one in DAMAGED])
def test_damage_is_told_in_german(tmp_path, name, text):
    (tmp_path / name).write_bytes(text.encode())
    with pytest.raises(EinschaltError) as error:
        read_foreign(tmp_path / name)
    with written_in("de"):
        assert not english_in(told(error.value)), told(error.value)


@pytest.mark.parametrize("name", READ)
def test_notes_of_reading_are_german(tmp_path, name):
    (tmp_path / name).write_bytes(READ[name][0].encode())
    notes = read_foreign(tmp_path / name).notes
    with written_in("de"):
        assert not english_in(" ".join(map(retold, notes)))
