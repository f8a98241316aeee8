"""True and stated precision of a simulated block, by three estimates."""

import numpy as np

import einschalt as es

block = es.simulate_block("neukirchen", seed=1)
settings = es.Settings(coverage_mean="most_central")  # as in 1971
result = es.densify(block, settings)

points = result.points[result.points["role"] == "new"]
true = block.truth.set_index("point_id").loc[points["point_id"]]
error = points[["easting", "northing"]].to_numpy() - true[["easting", "northing"]]
truth = np.sqrt(np.mean(np.sum(error.to_numpy() ** 2, axis=1)))

print("mean of two coverages, total, new points [cm]")
print(f"truth                                 {100 * truth:.1f}")
print(f"claim of the propagated errors        {100 * result.figures.mean_total:.1f}")
print(f"claim of the formula of 1971          {100 * result.figures.mean_paper:.1f}")
print(f"claim of the coverages' differences   {100 * result.figures.mean_internal:.1f}")
