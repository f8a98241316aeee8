"""What ``einschalt explain`` does."""

from einschalt.foundations.column_words import folded
from einschalt.foundations.errors import SettingsError
from einschalt.foundations.language import mark, translated
from einschalt.foundations.near_words import nearest
from einschalt.foundations.plan_column_meanings import PLAN_COLUMNS
from einschalt.foundations.plan_figure_meanings import (
    meanings_of_name,
    names_of_figures,
)
from einschalt.foundations.result_figure_meanings import (
    meanings_of_result,
    names_of_results,
)
from einschalt.foundations.result_files.meanings import (
    ASSESSMENT,
    MeaningInFile,
    meanings_in_files,
    names_with_values,
    words_of_files,
)
from einschalt.interfaces.cli.exits import print_out
from einschalt.interfaces.cli.explained_findings import (
    facts_of_finding,
    known_remedies,
)
from einschalt.interfaces.cli.outcome import report
from einschalt.interfaces.cli.setting_meanings import (
    explained_settings,
    names_of_settings,
    names_of_values,
    settings_with_values,
)
from einschalt.interfaces.files.columns_page import (
    ALL,
    explanation_of,
    facts_of_column,
    in_place,
    names_of_columns,
)
from einschalt.interfaces.files.glossary import entries
from einschalt.pipeline.summary.suggestions.catalogue import WORDS

TITLES = (
    *(mark("Findings"), mark("Settings"), mark("Terms"), mark("Figures of plans")),
    *(mark("Figures of results"), mark("Names in assessment.json and provenance.json")),
    mark("Remedies"),
)
# of a word that is written wrongly: one letter of six or seven
ALIKE = 0.85


def explain(term):
    """Print everything that a word means; a SettingsError where it means nothing."""
    if term == ALL:
        _print_all()
        return
    found = {
        "term": _terms(term),
        "setting": [{"text": text} for text in explained_settings(term)],
        "finding": [facts_of_finding(term)] if term in WORDS else [],
        "column": _column(term),
        "figure": _figure(term),
    }
    report(**{kind: meanings for kind, meanings in found.items() if meanings})
    texts = [one["text"] for meanings in found.values() for one in meanings]
    if not texts:
        near = _nearest(term)
        raise SettingsError(
            f"{term!r} is no term, setting, finding, column or figure",
            expected="a word that einschalt explain all lists",
            remedy=f"Write {near!r}" if near else "",
        )
    print_out("\n\n".join(texts))


def _print_all():
    """List findings, settings, terms and figures, and explain all columns."""
    lists = {
        "findings": WORDS,
        "settings": names_of_settings(),
        "terms": [one.heading for one in entries()],
        "figures": sorted(names_of_figures()),
        "result_figures": sorted(names_of_results()),
        "result_files": names_with_values(),
        "remedies": sorted(known_remedies()),
    }
    columns = explanation_of(ALL)
    report(**{name: list(words) for name, words in lists.items()}, columns=columns)
    lists["settings"] = settings_with_values()
    lists["result_files"] = [
        f"{name}: {'; '.join(words)}" if words else name
        for name, words in lists["result_files"].items()
    ]
    titles = map(translated, TITLES)
    for title, names in zip(titles, lists.values(), strict=True):
        print_out("\n".join([title, *(f"  {one}" for one in names), ""]))
    print_out(columns)


def _terms(term):
    """Entries of the glossary; a name of a figure is no plural of another word."""
    is_figure = term in names_of_figures() - _columns_of_plans()
    return [one.facts for one in entries() if one.is_meant(term, plural=not is_figure)]


def _columns_of_plans():
    return {name for columns in PLAN_COLUMNS.values() for name in columns}


def _column(name):
    try:
        return [facts_of_column(name)]
    except SettingsError:
        return []


def _figure(name):
    """Explain a name of JSON, of a plan's GeoPackage, or of a file of results."""
    found = [*meanings_of_name(name), *meanings_of_result(name)]
    lines = [in_place(one.place, one.text, one.unit) for one in found]
    places = [_place(one.place, one.text, one.unit) for one in found]
    for one in _in_files(name):
        lines.append(in_place(one.where, one.text, one.unit))
        values = {value: translated(text) for value, text in one.values.items()}
        lines += [f"    {value}: {text}" for value, text in values.items()]
        known = {"values": values} if values else {}
        places += [_place(at, one.text, one.unit) | known for at in one.each_where]
    text = "\n".join([name, *lines])
    return [{"name": name, "places": places, "text": text}] if lines else []


def _in_files(name):
    """What a name, a word or the code of a remedy means in files of results."""
    yield from meanings_in_files(name)
    if name and name in known_remedies():
        text = known_remedies()[name]
        yield MeaningInFile(ASSESSMENT, ("findings[].remedy",), "", text, value=name)


def _place(place, text, unit):
    return {"place": place, "meaning": translated(text), "unit": unit or None}


def _nearest(term):
    """Word that may be meant by one that is written wrongly; None of any other."""
    names = (
        *WORDS,
        *names_of_columns(),
        *names_of_figures(),
        *names_of_results(),
        *names_of_settings(),
        *names_of_values(),
        *words_of_files(),
        *known_remedies(),
        *(word for one in entries() for word in one.words),
        *(one.title for one in entries()),
    )
    known = {folded(name): name for name in names}
    return known.get(nearest(folded(term), known, alike=ALIKE))
