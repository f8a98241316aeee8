"""Which source the error of the new points comes from."""

from einschalt.foundations.typesetting import length, lengths
from einschalt.pipeline.summary.sections.section import Section

NAMES = {
    "control": "control points",
    "high_flight": "high flight, measurement",
    "low_flight": "low flight, measurement",
    "orientation": "relative orientation",
}
SMALLEST_SHARE = 0.005


def section(result) -> Section:
    """Say what each source contributes, the largest first; no rows where unknown."""
    table = result.block_error_sources
    if table.empty or not table["share"].sum() > 0.0:
        return Section("", (), ())
    sizes = table["standard_error_total"].to_numpy(dtype=float)
    whole = float((sizes**2).sum() ** 0.5)
    texts = lengths([*sizes, whole])
    rows = [
        (source_name(source), text, share_text(share))
        for source, text, share in zip(
            table["source"], texts[:-1], table["share"], strict=True
        )
    ]
    # all of the largest but half of it: what better measurements would bring
    better = (whole**2 - 0.75 * sizes[0] ** 2) ** 0.5
    remark = (
        f"With half the error of the first ({source_name(table['source'].iloc[0])}) "
        f"the new points would have {length(better)}."
    )
    return Section(
        "Sources of the error of the new points (total, RMS)",
        ("", "alone", "share of variance"),
        (*rows, ("all together", texts[-1], "100 %")),
        (remark,),
    )


def source_name(source) -> str:
    """Name of a source as people say it."""
    return NAMES.get(source, source.replace("_", " "))


def share_text(share) -> str:
    """Write a share in per cent.

    Examples
    --------
    >>> share_text(0.714), share_text(0.0004)
    ('71 %', '< 1 %')
    """
    return f"{100.0 * share:.0f} %" if share >= SMALLEST_SHARE else "< 1 %"
