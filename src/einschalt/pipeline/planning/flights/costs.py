"""What is paid for: prices of the items of a flight, and what they come to."""

from dataclasses import dataclass

from einschalt.foundations.arguments import require_kind
from einschalt.foundations.errors import SettingsError
from einschalt.foundations.known_fields import with_known_fields
from einschalt.foundations.value_ranges import Range, problems_in

COLUMN_OF_ITEM = {
    "image": "images",
    "model": "models",
    "setting": "settings",
    "control_point": "control_points",
}
"""Items that have a price, a field of PlanCosts, and where a plan has their amount."""


@with_known_fields
@dataclass(frozen=True, kw_only=True)
class PlanCosts:
    """What a plan is ranked by, in any one currency.

    Attributes
    ----------
    image : float
        Price of an image that is flown and developed.
    model : float
        Price of a model that is oriented.
    setting : float
        Price of a pointing at a point.
    control_point : float
        Price of a control point that is surveyed.
    """

    image: float = 10.0
    model: float = 20.0
    setting: float = 0.5
    control_point: float = 100.0

    def __post_init__(self):
        """Check the costs."""
        allowed = Range(0, 1e9)
        ranges = dict.fromkeys(self.__dataclass_fields__, allowed)
        for problem in problems_in(self, ranges):
            raise problem
        if not any(getattr(self, name) for name in ranges):
            raise SettingsError(
                "all prices are 0",
                expected="one price at least that is not 0",
                remedy="Give prices of what costs you something",
            )


def require_costs(costs):
    """See that prices are :class:`PlanCosts`."""
    require_kind(
        *("costs", costs, PlanCosts),
        expected="PlanCosts",
        remedy="Write costs=PlanCosts(image=12)",
    )


def cost_of(amounts, costs):
    """Cost of amounts of each item, numbers or arrays by the item.

    >>> cost_of({"image": 3, "model": 2, "setting": 0, "control_point": 1}, PlanCosts())
    170.0
    """
    return sum(amounts[item] * getattr(costs, item) for item in COLUMN_OF_ITEM)
