"""A flight that is planned with sliders: precision and cost at once, then a map."""

from dataclasses import dataclass
from math import floor, isfinite

from starlette.responses import JSONResponse

from einschalt.foundations.display_names import shortened
from einschalt.foundations.errors import EinschaltError
from einschalt.foundations.kept_texts import retold
from einschalt.foundations.language import figure, mark, mark_each, translated
from einschalt.foundations.number_parsing import is_number
from einschalt.foundations.typesetting import length, number
from einschalt.interfaces.local_page.drawings import precision_map
from einschalt.interfaces.local_page.pages import (
    messages_of,
    page,
    with_refusals,
    worked,
)
from einschalt.interfaces.local_page.refusals import RefusedError
from einschalt.pipeline.planning.choice.rows import design_of
from einschalt.pipeline.planning.estimate.search import (
    PlanChoices,
    PlanFrame,
    find_plans,
)
from einschalt.pipeline.planning.estimate.text import LIMITS
from einschalt.pipeline.planning.flights.cameras import CAMERAS, said_of_height
from einschalt.pipeline.planning.propagation.expected_precision import expect_precision

CAMERA = "film_wide"
HALF_TO_TWICE = (0.5, 2.0)
ANY_TARGET = 1.0  # of which nothing is asked here [m]
CM = 1e-2
REMEDIES = mark_each(
    {
        "measuring": "Set points more often, fly lower, or with more coverages",
        "noise": "Fly the high flight lower, or with more coverages",
        "transformation": "Fly the high flight lower, measure it better, or give its "
        "models nine control points",
        "control": "Survey the control better, or give nine points to each model",
    }
)
WORK = mark_each(
    {
        "cost": "cost per km² (estimate)",
        "images": "images per km²",
        "models": "models per km²",
        "settings": "pointings per km²",
        "control_points": "control points per km²",
    }
)
ROUNDED = 1e-9


@dataclass(frozen=True)
class Slider:
    """A value that is chosen: its range and what it is called."""

    name: str
    text: str
    unit: str
    least: float
    most: float
    step: float
    usual: float


def sliders_of(camera):
    """Sliders with the ranges of a camera and its usual flights."""
    preset = CAMERAS[camera]
    low, high = HALF_TO_TWICE
    scales, spacings = preset.scale_numbers, preset.spacings
    m_g = preset.m_g_um[-1]
    step = 100.0 if max(scales) >= 5_000.0 else 50.0
    return [
        Slider(
            *("scale_number", mark("Scale of the low flight, 1:"), ""),
            *(low * min(scales), high * max(scales), step, preset.usual_scale_number),
        ),
        Slider(
            *("high_over_low", mark("High flight, times that scale"), ""),
            *(1.25, 4.0, 0.125, 1.875),
        ),
        Slider(
            *("spacing", mark("Distance of the points"), "m"),
            *(
                low * min(spacings),
                high * max(spacings),
                min(spacings) / 20,
                preset.usual_spacing,
            ),
        ),
        Slider(
            *("m_g_um", mark("Error of one pointing, total"), "µm"),
            *(round(0.4 * m_g, 1), round(3.0 * m_g, 1), 0.1, m_g),
        ),
        Slider("n_settings", mark("Pointings of each point"), "", 1, 4, 1, 1),
        Slider("n_coverages", mark("Coverages"), "", 1, 3, 1, 2),
        Slider("control_cm", mark("Error of control, total"), "cm", 0.5, 10, 0.5, 3),
    ]


def _values(asked):
    """Camera and values of the sliders, the usual ones where nothing is said."""
    camera = asked.get("camera", CAMERA)
    camera = camera if camera in CAMERAS else CAMERA
    values = {}
    for slider in sliders_of(camera):
        values[slider.name] = _value(slider, asked.get(slider.name, ""))
    values["control_per_model"] = 9 if asked.get("control_per_model") == "9" else 5
    return camera, values


def _value(slider, text):
    """What a slider was set to, at its next step; the usual value if nothing.

    With either decimal sign; browsers know no place between two steps.
    """
    if not text.strip():
        return slider.usual
    number_text = text.replace(",", ".")
    if not is_number(number_text) or not isfinite(float(number_text)):
        raise RefusedError(
            f"{slider.name} = {shortened(text)!r} is not a number",
            expected="a number",
            remedy="Set the slider again",
        )
    value = min(max(float(number_text), slider.least), slider.most)
    n_steps = min(
        round((value - slider.least) / slider.step),
        floor((slider.most - slider.least) / slider.step + ROUNDED),
    )
    return round(slider.least + n_steps * slider.step, 9)


def _plan(camera, values):
    """The one plan of these values, and the frame in which it is made."""
    preset = CAMERAS[camera]
    frame = PlanFrame(
        image_format=preset.image_format,
        principal_distance=preset.principal_distance,
        forward_overlap=preset.forward_overlap,
        side_overlap=preset.side_overlap,
        control_standard_error=values["control_cm"] * CM,
    )
    names = ("scale_number", "spacing", "m_g_um", "high_over_low")
    chosen = {name: (values[name],) for name in names}
    for name in ("n_settings", "n_coverages", "control_per_model"):
        chosen[name] = (int(values[name]),)
    found = find_plans(ANY_TARGET, PlanChoices(**chosen), frame)
    return found.plans.iloc[0], frame


def figures_of(asked):
    """What these values give: figures with what they are, and what limits them."""
    try:
        camera, values = _values(asked)
        plan, _ = _plan(camera, values)
    except EinschaltError as error:
        return {"figures": [], "said": " ".join(messages_of(error)), "is_plan": False}
    shown = [("expected_mean", translated("expected, total (estimate)"))]
    if plan["n_coverages"] == 1:
        shown = [
            (
                "expected_centre",
                translated("expected in the middle of a model (estimate)"),
            ),
            ("expected_edge", translated("expected at its edge, total (estimate)")),
        ]
    figures = [(length(float(plan[name])), text) for name, text in shown]
    by_formula = length(float(plan["reached_paper"]))
    figures.append((by_formula, translated("by the formula of 1971, total")))
    figures += [
        (number(float(plan[name])), translated(text)) for name, text in WORK.items()
    ]
    height = figure(plan["high_flying_height"], ".0f")
    figures.append((f"{height} m", translated("high flight above ground")))
    limit = plan["limited_by"]
    text = translated(
        "It is limited by {limit}. {remedy}.",
        limit=translated(LIMITS[limit]),
        remedy=translated(REMEDIES[limit]),
    )
    text = f"{_too_high(camera, plan)}{text}"
    return {"figures": figures, "said": text, "is_plan": True}


def _too_high(camera, plan):
    """Say that a flight goes above what the camera's carrier may usually fly."""
    said = said_of_height(plan, CAMERAS[camera].max_height)
    return f"{retold(said)} " if said else ""


def map_of(asked):
    """Map of the expected precision as SVG, and its figure in a sentence."""
    plan, frame = _plan(*_values(asked))
    expected = expect_precision(design_of(plan, frame))
    figures = expected.figures
    shown = {translated("mean of the coverages"): figures.mean}
    if plan["n_coverages"] == 1:
        shown = {
            translated("middle of a model"): figures.single_centre,
            translated("its edge"): figures.single_edge,
        }
    said = ", ".join(f"{length(float(v))} ({what})" for what, v in shown.items())
    message = mark(
        "On this layout the points will have {figures}, total: the errors of control "
        "and of both flights, carried through every stage."
    )
    return {
        "svg": precision_map(expected.points),
        "said": translated(message, figures=said),
    }


@with_refusals
async def plan_page(request):
    """Sliders, and what they give."""
    camera, values = _values(request.query_params)
    return page(
        "plan",
        session=request.app.state.session,
        camera=camera,
        cameras={name: preset.title for name, preset in CAMERAS.items()},
        sliders=sliders_of(camera),
        values=values,
        answer=await worked(figures_of, request.query_params),
    )


@with_refusals
async def plan_figures(request):
    """Figures, for the script of the page."""
    return JSONResponse(await worked(figures_of, request.query_params))


@with_refusals
async def plan_map(request):
    """The map, for the script of the page."""
    try:
        drawn = await worked(map_of, request.query_params)
    except EinschaltError as error:
        return JSONResponse({"said": " ".join(messages_of(error))}, 422)
    return JSONResponse(drawn)
