"""A real block: five photographs of Strasbourg, oriented and transformed to the ground.

The models are formed from image coordinates and transformed directly onto surveyed
control.
"""

import einschalt as es

block = es.read_block("data_examples/sxb_strasbourg")
result = es.densify(block)
print(result)

orientations = result.orientations[["model_id", "n_points", "sigma_0", "is_converged"]]
print(orientations.to_string(index=False))

known = result.points[result.points["role"] != "new"]
differences = [name for name in known if name.startswith("difference_")]
print(known[["point_id", "role", "n_models", *differences]].round(3).to_string())
