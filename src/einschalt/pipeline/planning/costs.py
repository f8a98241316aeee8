"""What things cost that a plan is made of."""

from dataclasses import dataclass

from einschalt.foundations.value_ranges import Range, problems_in


@dataclass(frozen=True, kw_only=True)
class PlanCosts:
    """What a plan is ranked by, in any one currency."""

    # image, model, setting, control_point: to fly and develop an image, to orient a
    # model, to set a point once, to survey a control point
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
