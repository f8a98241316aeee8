"""Two national frames of Finland: one transformation for all, and one per triangle."""

import pandas as pd

import einschalt as es

folder = "data_examples/fi_ykj_tm35fin"
old = pd.read_csv(f"{folder}/model_points.csv")
new = pd.read_csv(f"{folder}/ground_points.csv")
corners = pd.read_csv(f"{folder}/triangles_model_points.csv")

for kind in ("helmert", "affine"):
    fit = es.transform_models(old, new, kind=kind)
    residuals = fit.residuals[["residual_easting", "residual_northing"]]
    print(fit)
    print("RMS of the residuals [m]", (residuals**2).mean().pow(0.5).round(3).to_dict())
    print(fit.proj_pipeline("all"), end="\n\n")

triangles = es.transform_models(corners, new, kind="affine")
print(f"{len(triangles.models)} triangles, largest residual in a corner [m]:")
print(triangles.residuals[["residual_easting", "residual_northing"]].abs().max().max())

# T0001 is the triangle that holds the point
point = pd.DataFrame({"model_id": "T0001", "point_id": ["P"], "x": 3.21e6, "y": 6.7e6})
print(triangles.transform(point).round(4).to_string(index=False))
