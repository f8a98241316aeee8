"""What ``einschalt simulate`` simulates: a preset, a camera's usual flight, a plan."""

from dataclasses import dataclass, replace
from functools import partial

from einschalt.foundations.errors import SettingsError
from einschalt.interfaces.cli.plan_heights import FlownHeights, heights_of
from einschalt.interfaces.cli.plan_values import flight_of, sides_and_distance
from einschalt.interfaces.cli.typed_options import option_of
from einschalt.pipeline.planning.flights.flight_design import (
    RIM_OVER_SIDE,
    FlightDesign,
)
from einschalt.pipeline.simulation.geometry import BlockGeometry
from einschalt.pipeline.simulation.noise import BlockNoise
from einschalt.pipeline.simulation.repetitions import Experiment
from einschalt.pipeline.simulation.simulate_block import PRESETS
from einschalt.theory.planning.leverage import PLANNED_KINDS

USUAL_PRESET = "neukirchen"
MEASURED = ("measurement", "transformation", "n_check")
GEOMETRY = tuple(BlockGeometry.__dataclass_fields__)
NOISE = tuple(BlockNoise.__dataclass_fields__)


@dataclass(frozen=True)
class Asked:
    """What is simulated, and the precision that was planned for it, if it was [m]."""

    experiment: Experiment
    planned: float | None = None
    heights: FlownHeights | None = None  # of a camera's flight


def asked_of(options) -> Asked:
    """Put together what the options of the command line ask for."""
    if options["plan"] is not None:
        return _of_plan(options)
    if options["row"] is not None:
        raise SettingsError(
            "--row without --plan",
            expected="the folder of the plans, of which it is one",
            remedy="Write --plan FOLDER as well",
        )
    if options["camera"] is None:
        return _of_preset(options)
    if options["preset"] is not None:
        raise SettingsError(
            "--preset beside --camera",
            expected="one of them: a preset has a camera of its own",
            remedy="Leave --preset out, or give --image-format and "
            "--principal-distance instead of --camera",
        )
    return _of_camera(options)


def _of_preset(options):
    """The block of a preset, with what was given in place of its values."""
    name = options["preset"] or USUAL_PRESET
    usual, given = PRESETS[name], dict(options)
    sides, distance = sides_and_distance(options)
    given["principal_distance"] = distance
    given["image_format"] = None
    if sides is not None:
        rim = min(sides) * RIM_OVER_SIDE
        given |= {"image_format": sides[0], "unusable_rim": rim}
        given["image_format_across"] = sides[-1]
    geometry = replace(usual.geometry, **_given(given, GEOMETRY))
    noise = replace(usual.noise, **_given(given, NOISE))
    return Asked(Experiment(name, geometry, noise, title=options["title"]))


def _of_camera(options):
    """The usual flight of a camera, laid out as ``einschalt plan --expect`` does."""
    # imported when a flight is planned: it takes propagation along
    from einschalt.pipeline.planning.area.simulated_plan import (  # noqa: PLC0415
        PlannedBlock,
    )

    kind = options["transformation"]
    kind = kind if kind in PLANNED_KINDS else "affine"
    flight = flight_of({**options, "kind": kind, "edge": "kovarik"})
    preset, model = flight.preset, flight.model
    usual = {
        "low_scale_number": preset.usual_scale_number,
        "point_spacing": preset.usual_spacing,
        "low_m_g_um": preset.m_g_um[0],
    }
    given = usual | _given(options, (*GEOMETRY, *NOISE))
    names = (
        *("n_coverages", "control_per_model", "width", "height"),
        *("high_scale_number", "high_m_g_um", "control_standard_error"),
    )
    design = FlightDesign(
        scale_number=given["low_scale_number"],
        spacing=given["point_spacing"],
        m_g_um=given["low_m_g_um"],
        kind=kind,
        image_format=model.image_format,
        principal_distance=flight.principal_distance,
        forward_overlap=model.forward_overlap,
        side_overlap=model.side_overlap,
        **{name: given[name] for name in names if name in given},
    )
    heights = heights_of(design, preset, preset.max_height, command="simulate")
    planned = PlannedBlock(design, float("nan"))
    return Asked(_experiment(planned, options), heights=heights)


def _of_plan(options):
    """The block of a plan, with what was given in place of its errors."""
    # imported when a plan is tried: it takes propagation and areas along
    from einschalt.interfaces.files.plan_file import read_plan_file  # noqa: PLC0415

    laid_out = (set(GEOMETRY) | {"preset", "camera"}) - set(MEASURED)
    wrong = sorted(name for name in _given(options, laid_out))
    if wrong:
        option = option_of(wrong[0])
        raise SettingsError(
            f"{option} beside --plan",
            expected="the layout of the plan as it is",
            remedy=f"Leave {option} out, or plan again",
        )
    planned = read_plan_file(options["plan"], options["row"])
    return Asked(_experiment(planned, options), planned.expected)


def _experiment(planned, options):
    noise = replace(planned.design.noise(), **_given(options, NOISE))
    changes = _given(options, MEASURED)
    title = options["title"]
    return Experiment(
        source=partial(planned.simulated, noise=noise, title=title, **changes)
    )


def _given(options, names):
    """What was given of some options."""
    return {name: options[name] for name in names if options.get(name) is not None}
