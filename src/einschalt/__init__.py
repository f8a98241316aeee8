"""Photogrammetric densification of control points, after Kovarik 1971.

Use
---
>>> import einschalt as es
>>> block = es.simulate_block("demo", seed=1)
>>> result = es.densify(block)
>>> print(result)  # doctest: +SKIP
>>> result.points  # doctest: +SKIP
>>> result.write("out/small")  # doctest: +SKIP
"""

from importlib import import_module

from einschalt.foundations.compiled_code import provide_cache

provide_cache()  # before anything is compiled

__version__ = "0.1.0"

_PUBLICATION = "einschalt.interfaces.publication"
_ORIENTATION = "einschalt.stages.relative_orientation"
# name -> module; imported on first use, so that planning and help start quickly
_HOME = {
    "read_block": "einschalt.interfaces.python_api",
    "read_points": "einschalt.interfaces.python_api",
    "Block": "einschalt.interfaces.python_api",
    "Flight": "einschalt.pipeline.block.block",
    "Camera": "einschalt.theory.interior_orientation",
    "Settings": "einschalt.pipeline.settings",
    "densify": "einschalt.interfaces.python_api",
    "DensificationResult": "einschalt.interfaces.python_api",
    "densify_many": "einschalt.interfaces.python_api",
    "approximate_coordinates": "einschalt.stages.stage1_approximate_coordinates",
    "relative_orientation": "einschalt.stages.stage2_relative_orientation",
    "transform_models": f"{_PUBLICATION}.published_results",
    "error_budget": "einschalt.stages.stage4_error_budget",
    "average_coverages": "einschalt.stages.stage5_double_coverage",
    "adjust_block": "einschalt.pipeline.densification.simultaneous",
    "orient_from_parallaxes": f"{_ORIENTATION}.orient_from_parallaxes",
    "orient_from_images": f"{_ORIENTATION}.orient_from_images",
    "plan_precision": "einschalt.pipeline.planning.precision_table",
    "optimal_scale": "einschalt.pipeline.planning.precision_table",
    "publish": f"{_PUBLICATION}.published_results",
    "export": "einschalt.interfaces.programs.export",
    "simulate_block": "einschalt.interfaces.python_api",
    "BlockGeometry": "einschalt.pipeline.simulation.simulate_block",
    "BlockNoise": "einschalt.pipeline.simulation.simulate_block",
    "EinschaltError": "einschalt.foundations.errors",
}

__all__ = [  # noqa: PLE0604 - the names are the keys of the table above
    "__version__",
    *_HOME,
]


def __getattr__(name):
    """Import a public name when it is first used."""
    if name not in _HOME:
        message = f"module 'einschalt' has no attribute {name!r}"
        raise AttributeError(message)
    value = getattr(import_module(_HOME[name]), name)
    globals()[name] = value
    return value


def __dir__():
    """List the public names."""
    return sorted(__all__)
