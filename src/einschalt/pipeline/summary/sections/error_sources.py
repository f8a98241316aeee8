"""Which source the error of the new points comes from."""

from einschalt.foundations.language import figure, mark_each, translated
from einschalt.foundations.typesetting import length, lengths
from einschalt.pipeline.summary.section import NO_SECTION, Section

NAMES = mark_each(
    {
        "control": "control points",
        "control_groups": "shifts of groups of control points",
        "approximate_points": "approximate points",
        "approximate_groups": "shifts of groups of approximate points",
        "high_flight": "high flight, measurement",
        "low_flight": "low flight, measurement",
        "orientation": "relative orientation",
        "reference_system": "operation between reference systems",
        "own_deformation": "deformation of each model",
        "shared_bend": "bend that models share",
    }
)
SMALLEST_SHARE = 0.005


def section(facts) -> Section:
    """Set what each source contributes, the largest first."""
    if facts is None:
        return NO_SECTION
    texts = lengths([*(source.total for source in facts.sources), facts.total])
    rows = [
        (source_name(source.source), text, share_text(source.share))
        for source, text in zip(facts.sources, texts[:-1], strict=True)
    ]
    remark = translated(
        "If the largest source ({source}) were halved, the new points would have "
        "{total}.",
        source=source_name(facts.sources[0].source),
        total=length(facts.total_with_half_the_largest),
    )
    return Section(
        translated("Sources of the error of the new points (total, RMS)"),
        ("", translated("alone"), translated("share of variance")),
        (*rows, (translated("combined"), texts[-1], "100 %")),
        (remark,),
    )


def source_name(source) -> str:
    """Name of a source as people say it."""
    return translated(NAMES.get(source, source.replace("_", " ")))


def share_text(share) -> str:
    """Write a share in per cent.

    Examples
    --------
    >>> share_text(0.714), share_text(0.0004)
    ('71 %', '< 1 %')
    """
    return f"{figure(100.0 * share, '.0f')} %" if share >= SMALLEST_SHARE else "< 1 %"
