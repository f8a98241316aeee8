"""Kovarik 1971 recomputed: every number of the text, the range it allows, and ours.

His diagrams are not available as pictures. If our number differs, the output gives the
reason.
"""

import textwrap

from einschalt.pipeline.planning.tables.kovarik_1971 import (
    compare_conclusions,
    compare_with_print,
)

compared = compare_with_print()
shown = compared.assign(
    printed=compared["printed"].map("{:.4g}".format),
    allowed=[f"{row.low:.4g} to {row.high:.4g}" for row in compared.itertuples()],
    ours=compared["ours"].map("{:.4g}".format),
    difference=compared["difference"].map("{:+.2g}".format),
    outside=compared["outside"]
    .map({0.0: ""}.get)
    .fillna(compared["outside"].map("{:.2f}".format)),
)
columns = ["printed", "allowed", "ours", "difference", "outside", "unit", "where"]
print(shown[columns].to_string(index=False, justify="right"))

print("\nWhere ours lies outside of what the rounding of the print allows:")
for row in compared[compared["outside"] > 0.0].itertuples():
    said = f"{row.where}: printed {row.printed:g}, ours {row.ours:.2f}: {row.why}."
    print(textwrap.fill(said, 88, initial_indent="- ", subsequent_indent="  "))

print("\nConclusions of the text")
for row in compare_conclusions().itertuples():
    said = f"{row.conclusion}: {['does not hold', 'holds'][row.holds]} ({row.because})"
    print(textwrap.fill(said, 88, initial_indent="- ", subsequent_indent="  "))
