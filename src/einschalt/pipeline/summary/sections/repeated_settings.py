"""Points that were set several times: m_g of their settings beside the given one."""

import numpy as np

from einschalt.foundations.typesetting import number
from einschalt.pipeline.summary.sections.section import Section
from einschalt.pipeline.summary.wording import with_error
from einschalt.theory.measuring_error import m_g_of_mean

SETTING_ALONE = (
    "Settings see the setting alone, not film, lens and model: a smaller figure than "
    "the given m_g is to be expected. A mean of k settings is taken to have m_g / √k."
)

REST = (
    "In the {}, if the rest of the given m_g is film, lens and model, a mean of {:.3g} "
    "settings has {} µm and not {}; m_g_um = {} makes it so."
)


def section(result) -> Section:
    """Say what repeated settings show; no rows where nothing was set twice."""
    rows = [
        (
            flight.flight.replace("_", " "),
            f"{flight.n_points:d}",
            f"{flight.n_settings:.0f}",
            f"{number(flight.m_g_um)} µm",
            f"{with_error(flight.m_g_settings_um, flight.standard_error_um)} µm",
            _verdict(flight),
        )
        for flight in result.repeated_settings.itertuples()
    ]
    header = ("", "points", "settings", "m_g given", "from settings", "verdict")
    title = "Repeated settings (m_g of one setting, total)"
    smaller = result.repeated_settings.query("is_smaller").itertuples()
    remarks = (SETTING_ALONE, *map(_rest, smaller))
    return Section(title, header, tuple(rows), remarks)


def _verdict(flight):
    if flight.is_larger:
        return "larger"
    return "smaller" if flight.is_smaller else "no contradiction"


def _rest(flight):
    """What a mean of settings has where these explain but a part of m_g."""
    k = flight.n_settings / flight.n_points
    averaged = flight.m_g_settings_um**2 * (1.0 - 1.0 / k)
    mean = np.sqrt(flight.m_g_um**2 - averaged)
    sizes = mean, m_g_of_mean(flight.m_g_um, k), mean * np.sqrt(k)
    return REST.format(flight.flight.replace("_", " "), k, *map(number, sizes))
