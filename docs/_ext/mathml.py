"""Formulas as MathML, which browsers set by themselves: no script, no fetched font."""

from docutils.nodes import SkipNode
from latex2mathml.converter import convert

# what the converter lacks, in its own words
SAME = {r"\tfrac": r"\frac", r"\bigl": r"\left", r"\bigr": r"\right"}


def as_mathml(latex, display):
    """MathML of a formula."""
    for given, known in SAME.items():
        latex = latex.replace(given, known)
    return convert(latex, display=display)


def visit_inline(writer, node):
    """Write a formula within a line."""
    writer.body.append(as_mathml(node.astext(), "inline"))
    raise SkipNode


def visit_display(writer, node):
    """Write a formula that stands by itself."""
    formula = as_mathml(node.astext(), "block")
    writer.body.append(f'<div class="math-display">{formula}</div>')
    raise SkipNode


def setup(app):
    """Register the way in which formulas are written."""
    app.add_html_math_renderer("mathml", (visit_inline, None), (visit_display, None))
    app.config.html_math_renderer = "mathml"
    return {"parallel_read_safe": True}
