"""Points that were set several times: m_g of their settings beside the given one."""

from einschalt.foundations.typesetting import number
from einschalt.pipeline.summary.section import Section
from einschalt.pipeline.summary.wording import flight_name, with_error

SETTING_ALONE = (
    "Settings see the setting alone, not film, lens and model: a smaller figure than "
    "the given m_g is to be expected. A mean of k settings is taken to have m_g / √k."
)
REST = (
    "In the {}, if the rest of the given m_g is film, lens and model, a mean of {:.3g} "
    "settings has {} µm and not {}; m_g_um = {} makes it so."
)


def section(flights) -> Section:
    """Set what repeated settings show."""
    rows = tuple(
        (
            flight_name(flight.flight),
            f"{flight.n_points:d}",
            f"{flight.n_settings:d}",
            f"{number(flight.m_g_um)} µm",
            f"{with_error(flight.m_g_settings_um, flight.standard_error_um)} µm",
            _verdict(flight),
        )
        for flight in flights
    )
    header = ("", "points", "settings", "m_g given", "from settings", "verdict")
    title = "Repeated settings (m_g of one setting, total)"
    rests = (_rest(flight) for flight in flights if flight.is_smaller)
    return Section(title, header, rows, (SETTING_ALONE, *rests))


def _verdict(flight):
    if flight.is_larger:
        return "larger"
    return "smaller" if flight.is_smaller else "no contradiction"


def _rest(flight):
    """What a mean of settings has where these explain but a part of m_g."""
    sizes = (
        flight.mean_if_rest_is_model_um,
        flight.mean_as_taken_um,
        flight.m_g_that_makes_it_so_um,
    )
    name = flight_name(flight.flight)
    return REST.format(name, flight.settings_each, *map(number, sizes))
