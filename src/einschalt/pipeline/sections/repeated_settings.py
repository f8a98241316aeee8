"""Points that were set several times: m_g of their settings beside the given one."""

from einschalt.foundations.typesetting import number
from einschalt.pipeline.sections.section import Section
from einschalt.pipeline.suspect_suggestions import shown_settings

SETTING_ALONE = (
    "Settings see the setting alone, not film, lens and model: a smaller figure than "
    "the given m_g is to be expected. A mean of k settings is taken to have m_g / √k."
)


def section(result) -> Section:
    """Say what repeated settings show; no rows where nothing was set twice."""
    rows = [
        (
            flight.flight.replace("_", " "),
            f"{flight.n_points:d}",
            f"{flight.n_settings:.0f}",
            f"{number(flight.m_g_um)} µm",
            f"{shown_settings(flight)} µm",
            "larger" if flight.is_larger else "no contradiction",
        )
        for flight in result.repeated_settings.itertuples()
    ]
    header = ("", "points", "settings", "m_g given", "from settings", "verdict")
    title = "Repeated settings (m_g of one setting, total)"
    return Section(title, header, tuple(rows), (SETTING_ALONE,))
