"""The glossary, docs/glossary.md, as entries that can be looked up.

It is in the package; a checkout has it in its docs.
"""

import re
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from einschalt.foundations.column_words import folded
from einschalt.foundations.language import ENGLISH, language, mark_each, translated
from einschalt.foundations.term_meanings import MEANINGS
from einschalt.foundations.typesetting import wrapped
from einschalt.interfaces.files.plain_formulas import without_latex

PACKAGE = Path(__file__).parents[2]
PLACES = (PACKAGE / "glossary.md", PACKAGE.parents[1] / "docs" / "glossary.md")
NOTHING = "–"
QUOTED = re.compile(r'"([^"]+)"')
MATHS = re.compile(r"\$([^$]*)\$")
# what stands in brackets after the words of a cell
REMARK = re.compile(r"(.*?)(?: \(([^()]*)\))?")
OF_SYMBOLS = re.compile(r"[,;=]").split
SECTIONS = mark_each(
    {
        "Points, flights, models": "Points, flights, models",
        "Planning": "Planning",
        "Relative orientation": "Relative orientation",
        "Transformation and adjustment": "Transformation and adjustment",
        "Methods and their authors": "Methods and their authors",
    }
)
NAMES = mark_each(
    {
        "German": "German",
        "English": "English",
        "symbol": "symbol",
        "unit": "unit",
        "code": "code",
    }
)


@dataclass(frozen=True)
class Entry:
    """A row of the glossary."""

    section: str
    cells: dict

    @property
    def title(self):
        """Its first word, in German."""
        return next(iter(self.cells.values()))

    @property
    def heading(self):
        """Its words in the active language, without LaTeX."""
        return self._words_and_remark[0]

    @property
    def _words_and_remark(self):
        """Words of the heading, and what English ones say in brackets after them."""
        if language() != ENGLISH:
            return _plain(self.title), ""
        words, remark = REMARK.fullmatch(_plain(self.cells["English"])).groups("")
        return words, remark

    @property
    def english(self):
        """Its first word in English, as meanings are told by."""
        first = re.split("[,;]", self.cells["English"])[0].strip()
        return re.sub(r" \([^)]*\)?$", "", first)

    @property
    def meaning(self):
        """What it means, in a sentence; empty where its words say that."""
        known = (MEANINGS.get(self.cells["English"]), MEANINGS.get(self.english))
        return translated(next(filter(None, known), ""))

    @property
    def text(self):
        """The entry as it is printed."""
        heading, remark = self._words_and_remark
        own = "English" if language() == ENGLISH else "German"
        said = [
            f"{translated(NAMES[name])}: {cell}"
            for name, cell in self.cells.items()
            if cell not in ("", NOTHING) and name != own
        ]
        section = translated(SECTIONS[self.section])
        said = [*filter(None, [self.meaning, remark]), *said]
        lines = [f"{heading} ({section})", *(_indented(one) for one in said)]
        return _plain("\n".join(lines))

    @property
    def facts(self):
        """The entry for programs: its cells by their names in small letters."""
        (_, title), *rest = self.cells.items()
        cells = {
            name.lower(): None if cell in ("", NOTHING) else _plain(cell)
            for name, cell in rest
        }
        named = {"title": _plain(title), "section": translated(SECTIONS[self.section])}
        return named | {"meaning": self.meaning or None} | cells | {"text": self.text}

    @property
    def words(self):
        """Words that stand for it, in its languages, and its symbol and code."""
        cells = ", ".join(c for name, c in self.cells.items() if name != "unit")
        symbols = [part for text in MATHS.findall(cells) for part in OF_SYMBOLS(text)]
        quoted = QUOTED.findall(cells)  # values of settings
        # without what stands in brackets, and with it
        words = re.split(r"[,;:/]| \(", re.sub(r"`|\)|\$[^$]*\$", "", cells))
        known = (word.strip() for word in (*words, *symbols, *quoted))
        return tuple(filter(None, known))

    def is_meant(self, term, *, plural=True):
        """Whether a word stands for it: in one of its languages, its symbol, its code.

        A plural of English counts as its singular, if that is wanted.
        """
        known = {folded(word) for word in self.words} - {""}
        wanted = folded(term)
        return wanted in known or (plural and wanted.removesuffix("s") in known)


def _plain(text):
    return without_latex(text.replace("`", ""))


def _indented(text):
    return wrapped(text, first="  ", indent="    ")


@cache
def entries():
    """All entries: tuple of Entry, in the order of the page."""
    page = next(place for place in PLACES if place.exists())
    section, names, found = "", (), []
    for line in page.read_text(encoding="utf-8").splitlines():
        if line.startswith("## "):
            section, names = line.removeprefix("## "), ()
        elif line.startswith("|") and not set(line) <= set("|-: "):
            cells = [cell.strip() for cell in re.split(r"(?<!\\)\|", line)[1:-1]]
            if names:
                found.append(Entry(section, dict(zip(names, cells, strict=True))))
            names = names or tuple(cells)
    return tuple(found)
