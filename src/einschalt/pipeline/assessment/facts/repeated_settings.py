"""Points that were set several times: m_g of their settings beside the given one."""

from dataclasses import dataclass

import numpy as np

from einschalt.theory.measuring_error import m_g_of_mean

AS_FOUND = {
    **dict.fromkeys(("n_points", "n_settings"), int),
    **dict.fromkeys(("m_g_um", "m_g_settings_um", "standard_error_um"), float),
    **dict.fromkeys(("is_larger", "is_smaller"), bool),
}


@dataclass(frozen=True)
class RepeatedSettingFacts:
    """What the repeated settings of one flight show; m_g TOTAL [µm]."""

    flight: str
    n_points: int
    n_settings: int
    m_g_um: float  # as given, of one setting
    # from the settings
    m_g_settings_um: float
    standard_error_um: float
    # whether chance does not explain the difference
    is_larger: bool
    is_smaller: bool
    settings_each: float  # mean number of settings of a point
    # of the mean of a point's settings, if the rest of the given m_g is film, lens and
    # model; and as it was taken, m_g / √k
    mean_if_rest_is_model_um: float
    mean_as_taken_um: float
    m_g_that_makes_it_so_um: float  # what to give for the former


def repeated_setting_facts(examined) -> tuple[RepeatedSettingFacts, ...]:
    """Collect what repeated settings show of every flight."""
    flights = examined.repeated_settings
    return tuple(map(_of_flight, flights.itertuples())) if len(flights) else ()


def _of_flight(flight):
    k = flight.n_settings / flight.n_points
    averaged = flight.m_g_settings_um**2 * (1.0 - 1.0 / k)
    # settings that scatter more than the given m_g leave nothing to the model
    mean = np.sqrt(max(flight.m_g_um**2 - averaged, 0.0))
    return RepeatedSettingFacts(
        flight=flight.flight,
        **{name: kind(getattr(flight, name)) for name, kind in AS_FOUND.items()},
        settings_each=float(k),
        mean_if_rest_is_model_um=float(mean),
        mean_as_taken_um=float(m_g_of_mean(flight.m_g_um, k)),
        m_g_that_makes_it_so_um=float(mean * np.sqrt(k)),
    )
