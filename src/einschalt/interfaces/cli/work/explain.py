"""What ``einschalt explain`` does."""

from difflib import get_close_matches

from einschalt.foundations.column_words import folded
from einschalt.foundations.errors import SettingsError
from einschalt.foundations.language import translated
from einschalt.interfaces.cli.exits import print_out
from einschalt.interfaces.cli.explained_findings import explained_finding
from einschalt.interfaces.cli.outcome import report
from einschalt.interfaces.files.columns_page import ALL, explanation_of
from einschalt.interfaces.files.glossary import entries
from einschalt.pipeline.summary.suggestions.catalogue import WORDS

KINDS = ("term", "finding", "column")


def explain(term):
    """Print everything that a word means; a SettingsError where it means nothing."""
    if term == ALL:
        codes, terms = WORDS, (one.title for one in entries())
        print_out("\n".join([translated("Findings"), *(f"  {one}" for one in codes)]))
        print_out("\n".join(["", translated("Terms"), *(f"  {one}" for one in terms)]))
        print_out(f"\n{explanation_of(ALL)}")
        return
    found = {
        "term": [one.text for one in entries() if one.is_meant(term)],
        "finding": [explained_finding(term)] if term in WORDS else [],
        "column": _column(term),
    }
    report(**{kind: "\n".join(texts) for kind, texts in found.items() if texts})
    texts = [text for texts in found.values() for text in texts]
    if not texts:
        known = {folded(one.title): one.title for one in entries()}
        known |= {folded(code): code for code in WORDS}
        near = get_close_matches(folded(term), known, n=1)
        raise SettingsError(
            f"{term!r} is no term, finding or column",
            expected="a word that einschalt explain all lists",
            remedy=f"Write {known[near[0]]!r}" if near else "",
        )
    print_out("\n\n".join(texts))


def _column(name):
    try:
        return [explanation_of(name).rstrip("\n")]
    except SettingsError:
        return []
