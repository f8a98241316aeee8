"""The long form of the truth tests: ``python -m tests.truth.long_form [part …]``.

Simulated blocks with known truth show whether what is claimed is what is so. Every
figure comes with its Monte Carlo error, from the scatter between blocks: the points of
one block are correlated and count for less than their number. The last figures stand
in docs/truth.md, which this writes itself; exit status 1 when a figure is out of its
bounds.
"""
