"""Which plans of a search are tried on their layouts, and in what order."""

from collections.abc import Callable
from copy import copy
from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy.special import ndtr

from einschalt.foundations.errors import EinschaltError
from einschalt.theory.measuring_error import m_g_of_mean

# of the logarithm of an error whose layout was propagated with other settings
SAME_LAYOUT = 0.01
# expected saving that a layout more is worth; of costs that are counted, not estimated
LEAST_GAIN, LEAST_COUNTED_GAIN = 0.02, 0.005
# of a cost that was not counted: as much cheaper it may well be [standard errors]
FAR_IN_COST = 2.0


@dataclass(frozen=True)
class _Sizes:
    """Standard errors of the parts of a logarithm, see _Shown."""

    common: float
    own: float
    single: float
    # for each step, in each of the columns of _steps_of or in all of them
    sloping: float | tuple[float, ...] = 0.0


OF_ERRORS = _Sizes(common=0.15, own=0.1, single=0.01)
OF_COSTS = _Sizes(common=0.12, own=0.06, single=0.04)
# high flights of much smaller scales are worse over small areas than the estimates know
OVER_AREAS = (
    _Sizes(common=0.15, own=0.08, single=0.01, sloping=(0.1, 0.2, 0.1, 0.1, 0.1)),
    _Sizes(common=0.12, own=0.06, single=0.04, sloping=0.05),
)
LAYOUT = (
    "scale_number",
    "high_scale_number",
    "spacing",
    "n_coverages",
    "control_per_model",
)


@dataclass
class Trials:
    """The plans that are left to be tried, and what the others have shown of them."""

    plans: pd.DataFrame
    target: float
    patience: int  # misses before all plans are taken to be as bad
    enough: int  # plans that are kept
    # of a plan as it is laid out, for each km²; gives None where no more are counted
    cost_on_layout: Callable | None = None

    def __post_init__(self):
        n_plans = len(self.plans)
        self.closed, self.estimate = (
            self.plans[name].to_numpy(dtype=float) for name in ("reached", "cost")
        )
        self.m_g = m_g_of_mean(
            *(self.plans[name].to_numpy() for name in ("m_g_um", "n_settings"))
        )
        self.steps = _steps_of(self.plans)
        self.layouts = self.plans[list(LAYOUT)].to_numpy(dtype=float)
        self.is_left = np.ones(n_plans, dtype=bool)
        self.of_layout = np.full(n_plans, np.nan)  # error that a tried layout tells [m]
        self.counted = np.full(n_plans, np.nan)  # costs
        self.is_asked = np.zeros(n_plans, dtype=bool)  # whether it was to be counted
        # costs are counted over areas only
        sizes = (OF_ERRORS, OF_COSTS) if self.cost_on_layout is None else OVER_AREAS
        self.errors, self.costs = (_Shown(self.steps, size) for size in sizes)
        # costs; of the plans that miss: reached over the closed estimate
        self.kept_costs, self.missed = [], []
        self.least_gain = (
            LEAST_GAIN if self.cost_on_layout is None else LEAST_COUNTED_GAIN
        )

    def extended(self, plans):
        """Give trials of more plans, of which these are the first.

        What the tried ones have shown is known of all.
        """
        longer = Trials(
            plans, self.target, self.patience, self.enough, self.cost_on_layout
        )
        n = len(self.plans)
        for name in ("is_left", "of_layout", "counted", "is_asked"):
            getattr(longer, name)[:n] = getattr(self, name)
        longer.errors, longer.costs = (
            shown.for_plans(longer.steps) for shown in (self.errors, self.costs)
        )
        longer.kept_costs, longer.missed = [*self.kept_costs], [*self.missed]
        longer.least_gain = self.least_gain
        return longer

    def next(self):
        """Give the plan that is to be tried next, None where none is worth it.

        The cheapest of those left that is likely to be kept, or else the most precise
        of all; where ``enough`` are kept, what promises most to be cheaper.
        """
        while self.is_left.any():
            likely, costs = self.likely(), self.likely_costs()
            is_good = self.is_left & (likely <= self.target)
            if is_good.any() and len(self.kept_costs) < self.enough:
                place = _first(is_good, costs, likely)
            elif self.kept_costs:
                gain = self._gain(likely, costs)
                place = int(np.argmax(gain))
                if gain[place] < self.least_gain:
                    return None
            elif self.missed and not self.promise:
                return None
            else:
                return self._taken(_first(self.is_left, likely, costs))
            if self.cost_on_layout is None or self.is_asked[place]:
                return self._taken(place)
            self._count(place)
        return None

    def next_ones(self, number):
        """Give up to so many plans that are to be tried beside each other.

        Each is the next one if those before it turn out as they are expected to, of a
        layout of its own.
        """
        found, before = [], self._before()
        while (plan := self.next()) is not None:
            found.append(plan)
            if len(found) == number:
                break
            self._expect(plan)
        self._put_back(before, found)
        return found

    def _before(self):
        """What expectations change."""
        return (
            self.is_left.copy(),
            self.errors.copy(),
            [*self.kept_costs],
            [*self.missed],
        )

    def _put_back(self, before, taken):
        self.is_left, self.errors, self.kept_costs, self.missed = before
        self.is_left[self.plans.index.get_indexer([plan.name for plan in taken])] = (
            False
        )

    def _expect(self, plan):
        """Take a plan for tried, with the error that it is likely to have."""
        place, likely = self.plans.index.get_loc(plan.name), self.likely()
        self.is_left &= ~self._has_layout_of(plan)
        ratio = np.inf
        if np.isfinite(self.closed[place]):  # the estimate knows a bound
            ratio = likely[place] / self.closed[place]
            self.errors.learn(place, ratio)
        if likely[place] <= self.target:
            self.kept_costs.append(self.likely_costs()[place])
        else:
            self.missed.append(ratio)

    def _count(self, place):
        """Count what a plan costs, which may no longer be the cheapest then."""
        self.is_asked[place] = True
        try:
            cost = self.cost_on_layout(self.plans.iloc[place])
        except EinschaltError:
            return  # it is tried as it is, and refused with this reason
        if cost is None:
            self.cost_on_layout = None
        else:
            self._take_cost(place, cost)

    def _take_cost(self, place, cost):
        if np.isnan(self.counted[place]) and min(cost, self.estimate[place]) > 0.0:
            self.counted[place] = cost
            self.costs.learn(place, cost / self.estimate[place])

    def likely_costs(self):
        """Cost of each plan, as far as is known; what may be counted may be less."""
        likely = self.estimate * self.costs.ratios
        if self.cost_on_layout is not None:
            far = np.exp(-FAR_IN_COST * self.costs.spreads)
            likely = np.where(self.is_asked, likely, likely * far)
        return np.where(np.isfinite(self.counted), self.counted, likely)

    def _taken(self, place):
        self.is_left[place] = False
        return self.plans.iloc[place]

    def _gain(self, likely, costs):
        """Expected saving of each plan that is left, of the best and the next best.

        As parts of the cheapest kept.
        """
        is_known = np.isfinite(self.of_layout)
        spread = np.where(is_known, SAME_LAYOUT, self.errors.spreads)
        chance = ndtr((np.log(self.target) - np.log(likely)) / spread)
        first, *others = sorted(self.kept_costs)
        saved = np.maximum(first - costs, 0.0)
        if others:
            saved += np.maximum(others[0] - np.maximum(costs, first), 0.0)
        saving = saved / max(first, np.finfo(float).tiny)
        return np.where(self.is_left, chance * saving, 0.0)

    def likely(self):
        """Error that each plan will have, as far as is known [m]."""
        likely = self.closed * self.errors.ratios
        if len(self.missed) > self.patience and not self.kept_costs:
            likely = np.maximum(likely, self.closed * max(self.missed))
        return np.where(np.isfinite(self.of_layout), self.of_layout, likely)

    def refuse(self, plan):
        """Leave out what has the layout of a plan that cannot be laid out."""
        self.is_left &= ~self._has_layout_of(plan)

    @property
    def promise(self):
        """Whether the closed estimate has plans that reach the target.

        The nearest plan need not be looked for any further.
        """
        return bool((self.closed <= self.target).any())

    def learn(self, checked, cost=None):
        """Take what a layout is better or worse than its estimate for its neighbours.

        The same layout with other settings has the same errors, those of measuring in
        proportion: as much or less with weights of their own. ``cost``: what the plan
        costs as it was laid out, if that is known.
        """
        plan, reached = checked.plan, checked.reached
        place = self.plans.index.get_loc(plan.name)
        ratio = reached / self.closed[place]
        if ratio > 0.0:  # not where the estimate knows no bound
            self.errors.learn(place, ratio)
        is_same = self._has_layout_of(plan)
        control = checked.propagated.share_of_control
        measuring = (1.0 - control) * (self.m_g[is_same] / self.m_g[place]) ** 2
        self.of_layout[is_same] = reached * np.sqrt(control + measuring)
        if cost is not None:
            self._take_cost(place, cost)
        if checked.is_kept:
            self.kept_costs.append(self.likely_costs()[place])
        else:
            self.missed.append(ratio)

    def _has_layout_of(self, plan):
        return (self.layouts == [float(plan[name]) for name in LAYOUT]).all(axis=1)


class _Shown:
    """What layouts are more or less than their estimates, for plans near them.

    Logarithms of the ratios have a part that is ``common`` to all layouts, one that
    grows evenly along each column of their steps (``sloping``), one that is alike for
    layouts near each other (``own``), and one that is of a ``single`` layout;
    interpolated with least variance (kriging).
    """

    def __init__(self, steps, sizes):
        self.steps, self.sizes = steps, sizes
        self.common, self.own, self.single = (
            size**2 for size in (sizes.common, sizes.own, sizes.single)
        )
        self.sloping = (steps - steps.mean(axis=0)) * sizes.sloping
        self.shown = []  # places and ratios
        self._columns = []  # covariances of all plans with each of these
        self._told = None  # what follows from them, asked for until there are more

    def for_plans(self, steps):
        """Give what is known for more plans, of which these are the first."""
        longer = _Shown(steps, self.sizes)
        for place, ratio in self.shown:
            longer.learn(place, ratio)
        return longer

    def learn(self, place, ratio):
        """Take what the plan at a place is, over its estimate."""
        self.shown.append((place, ratio))
        away = np.abs(self.steps - self.steps[place]).sum(axis=1)
        evenly = self.common + self.sloping @ self.sloping[place]
        self._columns.append(evenly + self.own * np.exp(-away))
        self._told = None

    def copy(self):
        """Give one that learns apart from this one."""
        copied = copy(self)
        copied.shown, copied._columns = [*self.shown], [*self._columns]
        return copied

    def _weights(self):
        """Weights of what was shown, and covariances with it, (n_plans, n_shown)."""
        covariances = np.column_stack(self._columns)
        places = [place for place, _ in self.shown]
        of_shown = covariances[places] + self.single * np.eye(len(places))
        return np.linalg.solve(of_shown, covariances.T).T, covariances

    @property
    def ratios(self):
        """What each plan is likely to be, over its estimate."""
        return self._of_all()[0]

    @property
    def spreads(self):
        """Standard errors of the logarithms of the ratios."""
        return self._of_all()[1]

    def _of_all(self):
        if self._told is None:
            self._told = self._interpolated()
        return self._told

    def _interpolated(self):
        """Ratios and spreads of all plans."""
        alike = self.common + self.own + self.single
        variance = alike + np.square(self.sloping).sum(axis=1)
        if not self.shown:
            return np.ones(len(self.steps)), np.sqrt(variance)
        weights, covariances = self._weights()
        ratios = np.exp(weights @ np.log([ratio for _, ratio in self.shown]))
        return ratios, np.sqrt(variance - (weights * covariances).sum(axis=1))


def _first(is_among, *keys):
    """Place of the least of some, by several keys."""
    among = np.flatnonzero(is_among)
    return among[np.lexsort([key[among] for key in reversed(keys)])[0]]


def _steps_of(plans):
    """Layouts in steps of which each makes the errors of two somewhat less alike."""
    low, high = plans["scale_number"], plans["high_scale_number"]
    logarithms = [np.log(part) for part in (low, high / low, plans["spacing"])]
    is_nine = plans["control_per_model"] == 9
    return np.column_stack([*logarithms, 0.5 * plans["n_coverages"], 0.5 * is_nine])
