"""What a notebook shows of a result, a block or a plan: short, its headline first.

Plain HTML in the colours of the page around it; no script, nothing from elsewhere.
"""

from html import escape
from textwrap import dedent

from einschalt.foundations.display_names import printable
from einschalt.foundations.kept_texts import retold
from einschalt.foundations.language import figure, mark, translated
from einschalt.foundations.typesetting import number, scale, wrapped
from einschalt.interfaces.reports.title_block import system_text
from einschalt.pipeline.summary.sections import known_points, precision
from einschalt.pipeline.summary.suggestions.catalogue import suggestions_of
from einschalt.pipeline.summary.verdict import verdict
from einschalt.pipeline.summary.wording import flight_name, transformation_name

MOST_PROBLEMS = 3
STYLE = "max-width: 50rem; line-height: 1.45"
SMALL = "margin: .4em 0 0; font-size: .9em; opacity: .75"
CELL = "padding: .1em 1em .1em 0; text-align: "


def result_card(result) -> str:
    """Verdict, the first problems, and the figures of the new and the known points."""
    told = result.assessment
    problems = [str(problem) for problem in suggestions_of(told.findings)]
    figures = (
        precision.section(told.precision, told.credible),
        known_points.section(told.known_points),
    )
    tables = [_table((s.title, *s.header[1:]), s.rows) for s in figures if s.rows]
    return _card(
        verdict(told),
        _items(problems, mark("and {n:more problem|more problems}")),
        *tables,
        _remark(
            translated(
                "More: print(result), result.plot.map(), result.report('report.html')"
            )
        ),
    )


def block_card(block) -> str:
    """What was measured, in numbers, and what was noted while it was read."""
    header = (
        "",
        translated("scale"),
        translated("fit"),
        translated("models"),
        translated("coverages"),
        translated("points"),
        "m_g",
    )
    rows = [_flight(name, flight) for name, flight in block.flights.items()]
    system = printable(system_text(block.crs))
    known = "; ".join(known_counts(block)) or translated("no known points")
    return _card(
        f"{block.name}: {known}",
        _table(header, rows),
        _remark(translated("Reference system: {system}.", system=system)),
        _items(
            [printable(retold(note)) for note in block.notes],
            mark("and {n:more note|more notes}"),
        ),
    )


def known_counts(block) -> list[str]:
    """How many points of which kind are given."""
    said = []
    control, given = block.control_points, block.approximate_points
    if control is not None:
        n_check = int((control["role"] == "check").sum()) if "role" in control else 0
        n_held = len(control) - n_check
        said.append(translated("{n:control point|control points}", n=n_held))
        if n_check:
            said.append(translated("{n:check point|check points}", n=n_check))
    if given is not None:
        message = mark("{n:approximate point|approximate points}")
        said.append(translated(message, n=len(given)))
    return said


def _flight(name, flight):
    n_points = flight.model_table()["point_id"].nunique()
    counts = (flight.n_models, flight.n_coverages, n_points)
    fit = transformation_name(flight.transformation)
    m_g = f"{number(flight.m_g_um)} µm"
    texts = [scale(flight.scale_number), fit, *map(figure, counts), m_g]
    return (flight_name(name), *texts)


def plan_card(plan) -> str:
    """Verdict of a plan, and its first table as it is printed."""
    _, _, rest = plan.summary().partition("\n\n")
    return _card(plan.verdict, f"<pre>{escape(rest)}</pre>")


def checked_plan_card(plan, outcome) -> str:
    """What a plan that was laid out comes to, then the rest of its verdict."""
    rest = plan.verdict().removeprefix(wrapped(outcome, indent="  "))
    return _card(outcome, f"<pre>{escape(dedent(rest).strip(chr(10)))}</pre>")


def _card(headline, *parts):
    head = f'<p style="margin: 0; font-weight: 600">{escape(printable(headline))}</p>'
    return f'<div style="{STYLE}">{head}{"".join(parts)}</div>'


def _items(texts, more):
    """The first of many texts as a list, and how many more there are."""
    if not texts:
        return ""
    shown = [*texts[:MOST_PROBLEMS]]
    if len(texts) > MOST_PROBLEMS:
        shown.append(translated(more, n=len(texts) - MOST_PROBLEMS))
    items = "".join(f"<li>{escape(text)}</li>" for text in shown)
    return f'<ul style="margin: .4em 0">{items}</ul>'


def _table(header, rows):
    """Table whose first column is words, the others numbers."""
    head = "".join(_cell("th", k, text) for k, text in enumerate(header))
    body = "".join(
        f"<tr>{''.join(_cell('td', k, text) for k, text in enumerate(row))}</tr>"
        for row in rows
    )
    return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"


def _cell(tag, column, text):
    style = f"{CELL}{'right' if column else 'left'}"
    return f'<{tag} style="{style}">{escape(printable(text))}</{tag}>'


def _remark(text):
    return f'<p style="{SMALL}">{escape(text)}</p>'
