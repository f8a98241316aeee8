"""Finsterwalder's 25 repetitions: one pair of photographs, oriented again and again.

In 1932 the spread of 25 orientations agreed only roughly with the standard errors of
least squares. The pair, however, had been oriented optically and mechanically. Bachmann
computed the errors of such a procedure, and found that repeating it does not clear the
model of parallaxes.
"""

import numpy as np
import pandas as pd

from einschalt.theory.relative_orientation import bachmann, gruber, hallert
from einschalt.theory.relative_orientation import parallax_equations as equations
from einschalt.theory.relative_orientation.six_points import FROM_1_TO_6

half_width, base, height, case = 95.0, 92.0, 152.0, "dependent_right"  # mm
sigma = 0.01  # mm, of one reading of one parallax
xyz = hallert.flat_six_points(half_width, base, height)[FROM_1_TO_6]
design = equations.design_matrix(xyz, base, case)
procedure = gruber.standard_procedure(design, case, tilt_at="5")

needed = np.array([2e-3, -1e-3, 3e-3, 0.4, -0.2])  # as the bundles happened to stand
parallaxes = np.tile(design @ needed, (25, 1))
rng = np.random.default_rng(1932)
record = gruber.run_procedure(
    procedure, design, parallaxes, n_passes=3, sigma=sigma, rng=rng
)
stationary = bachmann.stationary_covariance(bachmann.pass_matrices(procedure, design))
least_squares = hallert.flat_cofactor(half_width, base, height, case)
errors = {"25 repetitions": record.elements[-1].std(axis=0, ddof=1) * 1e3}
errors["Bachmann"] = sigma * np.sqrt(np.diag(stationary)) * 1e3
errors["least squares"] = sigma * np.sqrt(np.diag(least_squares)) * 1e3
print("standard errors of the elements [mrad; d_by, d_bz in µm]")
print(pd.DataFrame(errors, equations.ELEMENTS[case]).round(3), end="\n\n")

table = bachmann.compare_errors(procedure, design, passes=(1, 2, 5, 20))
rows = [*table.after_passes, table.stationary, table.least_squares]
names = [*(f"after pass {k}" for k in table.passes), "for ever", "least squares"]
print("parallaxes that remain in points 1 to 6, one reading = 1")
print(pd.DataFrame(rows, names, columns=range(1, 7)).round(2))
