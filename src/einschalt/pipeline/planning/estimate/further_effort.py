"""What would bring plans nearer to a target that has not been among their choices."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from einschalt.foundations.errors import GeometryError
from einschalt.foundations.language import figure, mark, mark_each, translated
from einschalt.foundations.typesetting import length, number, scale
from einschalt.pipeline.planning.flights.arguments import RANGES

MOST_PLANS = 500  # the most precise ones, which are changed
LEAST_GAIN = 0.03
"""Of the error: the closed estimate is not that exact."""
LESS = (0.8, 0.65, 0.5)  # of spacings, scale numbers, errors of control
MORE = (2, 4)  # times as many settings
NEARER = (1.25, 1.1)  # high flights, times the scale number of the low one
MOST_SETTINGS, MOST_COVERAGES = 16, 4
MOST_EFFORTS = 4  # that are said
EFFORT_TEXT = mark_each(
    {
        "spacing": "points {value} m apart (--spacing): {reached}",
        "scale_number": "low flights down to {value} (--scale-number): {reached}",
        "high_over_low": "high flights of {value} times the scale number "
        "(--high-over-low): {reached}",
        "n_settings": "{value} pointings each (--n-settings): {reached}",
        "n_coverages": "{value} coverages (--n-coverages): {reached}",
        "control_per_model": "{value} control points per model "
        "(--control-per-model): {reached}",
        "control_standard_error": "control of {value} (--control-standard-error): "
        "{reached}",
    }
)


@dataclass(frozen=True)
class FurtherEffort:
    """One choice more, and the error that the best plan then has [m]."""

    name: str  # a key of EFFORT_TEXT
    value: float
    reached: float

    def __str__(self):
        """Return the effort and its error in words."""
        write = {
            "scale_number": scale,
            "spacing": lambda spacing: number(spacing, 3),
            "control_standard_error": length,
        }.get(self.name, lambda value: figure(value, "g"))
        message = EFFORT_TEXT[self.name]
        return translated(
            message, value=write(self.value), reached=length(self.reached)
        )


@dataclass(frozen=True)
class FurtherEfforts:
    """The efforts that help, the most helpful first, and all of them together."""

    efforts: tuple[FurtherEffort, ...]
    together: float  # error [m]


def further_efforts(
    plans, choices, control_error, target, estimate: Callable
) -> FurtherEfforts:
    """Find what helps beyond the choices of a search that does not reach its target.

    ``plans`` are columns of its most precise plans, as the choices name them;
    ``estimate(plans, control_error)`` gives the errors of changed ones [m]. Of each
    effort the least that reaches the target, or the greatest.
    """
    best = estimate(plans, control_error).min()

    def error_with(changes):
        changes = dict(changes)
        control = changes.pop("control_standard_error", control_error)
        n_plans = len(plans["spacing"])
        changed = {name: np.full(n_plans, value) for name, value in changes.items()}
        try:
            return float(estimate(plans | changed, control).min())
        except GeometryError:  # no plan is left: too few points, or too high
            return np.inf

    found = []
    for name, values in _values_beyond(choices, control_error).items():
        errors = [error_with({name: value}) for value in values]
        if not errors:
            continue
        does = [k for k, error in enumerate(errors) if error <= target]
        k = does[0] if does else int(np.argmin(errors))
        if np.isfinite(errors[k]) and errors[k] <= (1.0 - LEAST_GAIN) * best:
            found.append(FurtherEffort(name, values[k], errors[k]))
    found.sort(key=lambda effort: effort.reached)
    together = error_with({effort.name: effort.value for effort in found})
    return FurtherEfforts(tuple(found), together)


def _values_beyond(choices, control_error):
    """Give the values of each choice that have not been tried, and go further."""
    least = {name: min(getattr(choices, name)) for name in ("spacing", "scale_number")}
    most = max(choices.n_settings)
    values = {
        name: [_round(part * value) for part in LESS] for name, value in least.items()
    }
    for name in least:
        values[name] = [v for v in values[name] if v >= RANGES[name].low]
    nearest = min(choices.high_over_low)
    values["high_over_low"] = [ratio for ratio in NEARER if ratio < nearest]
    settings = (most * times for times in MORE)
    values["n_settings"] = [n for n in settings if n <= MOST_SETTINGS]
    coverages = range(int(max(choices.n_coverages)) + 1, MOST_COVERAGES + 1)
    values["n_coverages"] = list(coverages)
    values["control_per_model"] = [9] if max(choices.control_per_model) < 9 else []
    values["control_standard_error"] = [part * control_error for part in LESS]
    return values


def _round(value):
    return float(f"{value:.2g}")


def describe_efforts(search) -> str:
    """Say what helps that was not among the choices; nothing if it was not sought."""
    if search.beyond is None:
        return ""
    efforts, together = search.beyond.efforts, search.beyond.together
    if not efforts:
        return translated("Nothing that was not tried would help by 3 % or more.")
    reaching = [effort for effort in efforts if effort.reached <= search.target]
    if reaching:
        return translated(
            "Not tried, and would reach it by the closed estimate: {efforts}.",
            efforts=", ".join(map(str, reaching)),
        )
    message = mark("Not tried, and would help by the closed estimate: {efforts}.")
    if together < efforts[0].reached:  # possible at once, and worth it
        message = mark(
            "Not tried, and would help by the closed estimate: {efforts}; all of them "
            "together: {together}."
        )
    said = ", ".join(map(str, efforts[:MOST_EFFORTS]))
    return translated(message, efforts=said, together=length(together))
