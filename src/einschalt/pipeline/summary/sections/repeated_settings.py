"""Points that were set several times: m_g of their settings beside the given one."""

from einschalt.foundations.language import figure, mark, translated
from einschalt.foundations.typesetting import number
from einschalt.pipeline.summary.section import Section
from einschalt.pipeline.summary.wording import flight_name, with_error

SETTING_ALONE = mark(
    "Repeated settings show the error of setting alone, without film, lens and model: "
    "it should be smaller than the given m_g. A mean of k settings is assumed to have "
    "m_g / √k."
)
REST = mark(
    "{flight}: if the rest of the given m_g comes from film, lens and model, a mean of "
    "{k} settings has {true} µm, not {taken} µm; m_g_um = {m_g} corrects for that."
)


def section(flights) -> Section:
    """Set what repeated settings show."""
    rows = tuple(
        (
            flight_name(flight.flight),
            figure(flight.n_points, "d"),
            figure(flight.n_settings, "d"),
            f"{number(flight.m_g_um)} µm",
            f"{with_error(flight.m_g_settings_um, flight.standard_error_um)} µm",
            _verdict(flight),
        )
        for flight in flights
    )
    header = (
        *("", translated("points"), translated("settings"), translated("m_g given")),
        *(translated("from settings"), translated("verdict")),
    )
    title = translated("Repeated settings (m_g of one setting, total)")
    rests = (_rest(flight) for flight in flights if flight.is_smaller)
    return Section(title, header, rows, (translated(SETTING_ALONE), *rests))


def _verdict(flight):
    if flight.is_larger:
        return translated("larger")
    if flight.is_smaller:
        return translated("smaller")
    return translated("no contradiction")


def _rest(flight):
    """What a mean of settings has where these explain but a part of m_g."""
    return translated(
        REST,
        flight=flight_name(flight.flight),
        k=figure(flight.settings_each, ".3g"),
        true=number(flight.mean_if_rest_is_model_um),
        taken=number(flight.mean_as_taken_um),
        m_g=number(flight.m_g_that_makes_it_so_um),
    )
