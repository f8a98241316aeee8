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

TYPE_CHECKING = False  # not from typing, which takes longer than all the rest here
if TYPE_CHECKING:  # the same names, for editors and type checkers
    from einschalt.foundations.errors import EinschaltError as EinschaltError
    from einschalt.foundations.language import written_in as written_in
    from einschalt.interfaces.programs.export import export as export
    from einschalt.interfaces.publication.published_results import publish as publish
    from einschalt.interfaces.publication.published_results import (
        transform_models as transform_models,
    )
    from einschalt.interfaces.python_api import Block as Block
    from einschalt.interfaces.python_api import (
        DensificationResult as DensificationResult,
    )
    from einschalt.interfaces.python_api import densify as densify
    from einschalt.interfaces.python_api import densify_many as densify_many
    from einschalt.interfaces.python_api import read_block as read_block
    from einschalt.interfaces.python_api import read_points as read_points
    from einschalt.interfaces.python_plans import AreaPlan as AreaPlan
    from einschalt.interfaces.python_plans import CheckedPlan as CheckedPlan
    from einschalt.interfaces.python_plans import ExpectedPrecision as ExpectedPrecision
    from einschalt.interfaces.python_plans import PlanSearch as PlanSearch
    from einschalt.interfaces.python_plans import expect_precision as expect_precision
    from einschalt.interfaces.python_plans import find_plans as find_plans
    from einschalt.interfaces.python_plans import plan_area as plan_area
    from einschalt.interfaces.python_plans import plan_target as plan_target
    from einschalt.interfaces.python_simulation import simulate_block as simulate_block
    from einschalt.interfaces.python_simulation import simulate_plan as simulate_plan
    from einschalt.pipeline.adjust_block import adjust_block as adjust_block
    from einschalt.pipeline.block.block import Flight as Flight
    from einschalt.pipeline.planning.area.flight_plan import FlightPlan as FlightPlan
    from einschalt.pipeline.planning.estimate.search import PlanChoices as PlanChoices
    from einschalt.pipeline.planning.estimate.search import PlanFrame as PlanFrame
    from einschalt.pipeline.planning.flights.cameras import CameraPreset as CameraPreset
    from einschalt.pipeline.planning.flights.cameras import (
        camera_preset as camera_preset,
    )
    from einschalt.pipeline.planning.flights.costs import PlanCosts as PlanCosts
    from einschalt.pipeline.planning.flights.flight_design import (
        FlightDesign as FlightDesign,
    )
    from einschalt.pipeline.planning.tables.precision_table import (
        optimal_scale as optimal_scale,
    )
    from einschalt.pipeline.planning.tables.precision_table import (
        plan_precision as plan_precision,
    )
    from einschalt.pipeline.settings import Settings as Settings
    from einschalt.pipeline.simulation.simulate_block import (
        BlockGeometry as BlockGeometry,
    )
    from einschalt.pipeline.simulation.simulate_block import BlockNoise as BlockNoise
    from einschalt.stages.relative_orientation.orient_from_images import (
        orient_from_images as orient_from_images,
    )
    from einschalt.stages.relative_orientation.orient_from_parallaxes import (
        orient_from_parallaxes as orient_from_parallaxes,
    )
    from einschalt.stages.stage1_approximate_coordinates import (
        approximate_coordinates as approximate_coordinates,
    )
    from einschalt.stages.stage2_relative_orientation import (
        relative_orientation as relative_orientation,
    )
    from einschalt.stages.stage4_error_budget import error_budget as error_budget
    from einschalt.stages.stage5_double_coverage import (
        average_coverages as average_coverages,
    )
    from einschalt.theory.interior_orientation import Camera as Camera

_PUBLICATION = "einschalt.interfaces.publication"
_ORIENTATION = "einschalt.stages.relative_orientation"
_PLANNING = "einschalt.pipeline.planning"
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
    "adjust_block": "einschalt.pipeline.adjust_block",
    "orient_from_parallaxes": f"{_ORIENTATION}.orient_from_parallaxes",
    "orient_from_images": f"{_ORIENTATION}.orient_from_images",
    "plan_precision": f"{_PLANNING}.tables.precision_table",
    "optimal_scale": f"{_PLANNING}.tables.precision_table",
    "camera_preset": f"{_PLANNING}.flights.cameras",
    "CameraPreset": f"{_PLANNING}.flights.cameras",
    "expect_precision": "einschalt.interfaces.python_plans",
    "ExpectedPrecision": "einschalt.interfaces.python_plans",
    "FlightDesign": f"{_PLANNING}.flights.flight_design",
    "find_plans": "einschalt.interfaces.python_plans",
    "PlanSearch": "einschalt.interfaces.python_plans",
    "plan_target": "einschalt.interfaces.python_plans",
    "CheckedPlan": "einschalt.interfaces.python_plans",
    "plan_area": "einschalt.interfaces.python_plans",
    "AreaPlan": "einschalt.interfaces.python_plans",
    "FlightPlan": f"{_PLANNING}.area.flight_plan",
    "PlanChoices": f"{_PLANNING}.estimate.search",
    "PlanFrame": f"{_PLANNING}.estimate.search",
    "PlanCosts": f"{_PLANNING}.flights.costs",
    "publish": f"{_PUBLICATION}.published_results",
    "export": "einschalt.interfaces.programs.export",
    "simulate_block": "einschalt.interfaces.python_simulation",
    "simulate_plan": "einschalt.interfaces.python_simulation",
    "BlockGeometry": "einschalt.pipeline.simulation.simulate_block",
    "BlockNoise": "einschalt.pipeline.simulation.simulate_block",
    "EinschaltError": "einschalt.foundations.errors",
    "written_in": "einschalt.foundations.language",
}

__all__ = [  # noqa: PLE0604 - the names are the keys of the table above
    "__version__",
    *_HOME,
]


if not TYPE_CHECKING:  # to a type checker a name that is not there is an error

    def __getattr__(name):
        """Import a public name when it is first used."""
        if name not in _HOME:
            message = f"module 'einschalt' has no attribute {name!r}"
            raise AttributeError(message)
        value = getattr(import_module(_HOME[name]), name)
        globals()[name] = value
        return value


def __dir__() -> list[str]:
    """List the public names."""
    return sorted(__all__)
