"""The five stages of a block, one call each: from two flights to coordinates.

``es.densify(block)`` does the same in one call, keeps check points out of every
adjustment, and gives a report.
"""

import einschalt as es

block = es.read_block("data_examples/neukirchen")
high, low = block.high_flight, block.low_flight

approximate = es.approximate_coordinates(
    high.model_points, block.control_points, high.transformation
)
oriented = es.relative_orientation(low)
transformed = es.transform_models(
    oriented.model_points, approximate.points, low.transformation
)
values = transformed.values(oriented.model_points)
values["standard_error_paper"] = es.error_budget(
    low.m_g_um, low.scale_number, values["m_t"]
)
final = es.average_coverages(values)

for stage in (approximate, oriented, transformed, final):
    print(stage, end="\n\n")
print(final.points.head().to_string(index=False))
