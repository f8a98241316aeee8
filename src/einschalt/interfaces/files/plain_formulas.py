r"""Formulas of our pages, which are LaTeX, as plain text for a terminal.

Only what the glossary has is known; other commands would keep their backslash, which a
test forbids.
"""

import re

GREEK = {"alpha": "α", "gamma": "γ", "delta": "δ", "theta": "θ", "kappa": "κ"}
GREEK |= {"nu": "ν", "sigma": "σ", "varphi": "φ", "omega": "ω", "Delta": "Δ"}
SIGNS = GREEK | {"nabla": "∇", "sqrt": "√", "dots": "… ", "mathrm": "", ",": " "}
FORMULA = re.compile(r"\$([^$]*)\$")
COMMAND = re.compile(r"\\([A-Za-z]+|,)[ \t]*")
RAISED = {"^*": "*", "^0": "⁰", "^b": "ᵇ"}
MINUS = re.compile(r"(?<=\S)-(?=\S)|(?<= )-(?= )")


def without_latex(text):
    r"""Text whose formulas, between dollar signs, are plain.

    >>> without_latex(r"$m_0 = \sqrt 2\, s_0$, $w_{pk}$, $a_0 \dots b_2$")
    'm_0 = √2 s_0, w_pk, a_0 … b_2'
    >>> without_latex(r"$\mathrm d\omega_1 - k^*$")
    'dω_1 − k*'
    """
    return FORMULA.sub(lambda found: _plain(found[1]), text)


def _plain(formula):
    text = COMMAND.sub(lambda found: SIGNS.get(found[1], found[0]), formula)
    for raised, plain in RAISED.items():
        text = text.replace(raised, plain)
    return MINUS.sub("\N{MINUS SIGN}", re.sub("[{}]", "", text))
