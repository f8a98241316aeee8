"""Affinity of film and strain of the control network: what was looked for and found."""

from einschalt.foundations.typesetting import length
from einschalt.pipeline.assessment.systematic_errors import beyond_strain_test
from einschalt.pipeline.summary.sections.section import Section
from einschalt.pipeline.summary.wording import ppm

REMARK = (
    "Affinity: by how much x is longer than y in all models of a flight, and the "
    "right angle between them smaller (1 ppm is 1 mm in a km). Strain: errors "
    "that neighbouring control points share; total, RMS."
)
NO_STRAIN = (
    "Strain was not looked for: errors of the orientations bend models, which would "
    "pass for it."
)
TOO_LARGE = "Strain was not looked for: the block is too large for it ({})."
ONE_BY_ONE = 'method = "simultaneous" tests each control point beside them.'


def section(result) -> Section:
    """Say what patterns there are; no rows where they could not be tested."""
    rows = [row for found in result.patterns.affinities for row in _affinity(found)]
    if result.patterns.strain is not None:
        rows.append(_strain(result.patterns.strain))
    title = "Systematic patterns: affinity of film, strain of control"
    return Section(
        title, ("", "found", "verdict"), tuple(rows), (REMARK, *_untested(result))
    )


def _untested(result):
    """Say why strain was not looked for."""
    if result.patterns.strain is not None:
        return ()
    if any((result.orientation_errors or {}).values()):
        is_weighed = not any(f.has_images for f in result.block.flights.values())
        return (f"{NO_STRAIN} {ONE_BY_ONE}" if is_weighed else NO_STRAIN,)
    size = beyond_strain_test(result)
    return (TOO_LARGE.format(size),) if size else ()


def _affinity(found):
    flight = found.flight.replace("_", " ")
    if not found.is_significant:
        verdict = "none"
    elif found.is_absorbed:
        verdict = "significant, taken up by affine"
    else:
        verdict = f"significant, adds {length(found.bias)}"
    return (
        (
            f"{flight}, x against y",
            ppm(found.stretch, found.stretch_error),
            verdict,
        ),
        (f"{flight}, shear", ppm(found.shear, found.shear_error), ""),
    )


def _strain(found):
    name = f"{found.n_control} control points"
    if not found.is_significant:
        return name, "–", "none"
    if not found.is_smooth:
        return name, "–", "single points"
    return name, f"{length(found.size)} over {length(found.reach)}", "significant"
