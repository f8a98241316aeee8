"""One frozen Settings: how a block is computed, checked on construction."""

from difflib import get_close_matches
from numbers import Real
from typing import Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError, field_validator
from pydantic_core import PydanticCustomError

from einschalt.foundations.arguments import described
from einschalt.foundations.display_names import shortened
from einschalt.foundations.errors import BlockError, SettingsError
from einschalt.foundations.number_parsing import describe_fault, is_number

NO_TOLERANCE = "none"
TOLERANCES = (NO_TOLERANCE, "vermv_1994", "vermv_2010", "vermv_2016")
LARGEST_TOLERANCE = 10.0  # metres


class Settings(BaseModel):
    """How a block is computed; every field has a default.

    Attributes
    ----------
    method : {"pipeline", "simultaneous"}
        The two-step way of Kovarik 1971, or all models of all flights and the control
        in one adjustment.
    coverage_mean : {"all", "most_central"}
        Which models give a point's coordinates: every model that holds it, or, as in
        1971, per coverage the model in which max(|u|, |v|) is smallest, u and v being
        the position in the model's extent.
    weighting : {"plain", "weighted"}
        Arithmetic mean, or weights 1 / M² with the M of the error budget.
    outliers : {"keep", "snoop", "huber", "tukey"}
        What happens to gross errors: they are only named; the worst of each low-flight
        model is taken out until none is left; or a robust norm gives them less weight.
        Unless they are kept, measurements of either flight take no part that contradict
        the other models of their flight when these are adjusted simultaneously, and
        the value of a suspect does not enter the mean of its point where another model
        has one that is not suspect.
    screening : {"propagated", "practice_1968", "off"}
        How a point is found whose coverages differ by more than they may: by the
        propagated precision of the difference, or, as in the double coverages of 1968,
        by three standard errors that come from all differences. A suspect keeps the
        values of its coverages beside their mean.
    iterations : int
        How often the low flight is transformed at most: again onto the coordinates
        that it gave, with control points held, until nothing moves by 1 mm.
    model_deformation : {"modelled", "tested", "ignored"}
        With ``method = "simultaneous"``: whether deformations that all models of a
        flight share are modelled where a test finds them, only tested, or neither.
    variance_components : {"given", "estimated"}
        With ``method = "simultaneous"``: whether control and flights have the errors
        that were given, or those that their residuals show.
    significance : float
        Probability with which a model without gross errors has a suspect residual, and
        with which a point without gross errors is suspected for its coverages.
    residual_distribution : {"none", "natural_neighbour", "inverse_distance", \
            "multiquadric"}
        How the residuals of control points are distributed to the points between, for
        a cadastre that must fit: control then keeps its given coordinates.

    tolerance : {"none", "vermv_1994", "vermv_2010", "vermv_2016"} or float
        Standard error, TOTAL [m], that a point may have: of an Austrian surveying
        ordinance, or any other. Every point then passes or fails.
    confidence : float
        Probability with which the ellipses of the points hold the true point; 0.393
        gives the mean error ellipse.

    Raises
    ------
    SettingsError
        A field is unknown or its value is not allowed.

    Examples
    --------
    >>> Settings(coverage_mean="most_central").weighting
    'plain'
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    method: Literal["pipeline", "simultaneous"] = "pipeline"
    coverage_mean: Literal["all", "most_central"] = "all"
    weighting: Literal["plain", "weighted"] = "plain"
    outliers: Literal["keep", "snoop", "huber", "tukey"] = "keep"
    screening: Literal["propagated", "practice_1968", "off"] = "propagated"
    iterations: int = Field(
        1, ge=1, le=100, strict=True, description="a whole number from 1 to 100"
    )
    model_deformation: Literal["modelled", "tested", "ignored"] = "modelled"
    variance_components: Literal["given", "estimated"] = "given"
    significance: float = Field(
        0.001, gt=0.0, lt=1.0, description="a probability above 0 and below 1"
    )
    residual_distribution: Literal[
        "none", "natural_neighbour", "inverse_distance", "multiquadric"
    ] = "none"
    tolerance: str | float = Field(
        NO_TOLERANCE,
        description=f"{', '.join(TOLERANCES)}, or a number of metres above 0, at most "
        f"{LARGEST_TOLERANCE:g}",
    )
    confidence: float = Field(
        0.95, gt=0.0, lt=1.0, description="a probability above 0 and below 1"
    )

    def __init__(self, **fields):
        checked(super().__init__, fields, section="settings", names=type(self))

    @field_validator("tolerance", mode="before")
    @classmethod
    def _preset_or_metres(cls, value):
        if isinstance(value, str) and value in TOLERANCES:
            return value
        if isinstance(value, str) and not is_number(value):
            said = {"expected": ", ".join(TOLERANCES)}
            raise PydanticCustomError("literal_error", "an unknown tolerance", said)
        metres = float(value) if isinstance(value, str) else value
        is_number_of = isinstance(metres, Real) and not isinstance(metres, bool)
        if not is_number_of or not 0.0 < metres < np.inf:
            raise PydanticCustomError("value_error", "no tolerance")
        if metres > LARGEST_TOLERANCE:
            raise PydanticCustomError("less_than_equal", "too large")
        return float(metres)

    @property
    def averaging(self):
        """How the values of a point are averaged, as arguments."""
        return {"coverage_mean": self.coverage_mean, "weighting": self.weighting}


def checked(build, fields, *, section, names, file=None):
    """Build a pydantic model and say what is wrong in the words of the project.

    Parameters
    ----------
    build : callable
        The constructor that validates.
    fields : dict
    section : str
        Section of block.toml, said in messages.
    names : type
        The model, for the nearest known name of an unknown key.
    file : str, optional

    Raises
    ------
    SettingsError, BlockError
        One or several keys are unknown, missing, or have a value that is not allowed.
    """
    try:
        return build(**fields)
    except ValidationError as error:
        problems = [
            setting_problem(fault, section, names, file=file)
            for fault in error.errors()
        ]
    if len(problems) == 1:
        raise problems[0]
    raise BlockError(problems)


def setting_problem(fault, section, names, *, file=None):
    """Say in the words of the project what pydantic found.

    Parameters
    ----------
    fault : dict
        One of ``ValidationError.errors()``.
    section : str
        Section of block.toml, said in the message.
    names : type
        The model: its fields are the known keys, their descriptions are said as what
        was expected.
    file : str, optional

    Returns
    -------
    SettingsError
    """
    key = ".".join(shortened(str(part)) for part in fault["loc"]) or section
    where = f"[{section}] {key}"
    if fault["type"] == "extra_forbidden":
        near = get_close_matches(key.casefold(), names.model_fields, n=1)
        return SettingsError(
            f"{where}: unknown key",
            expected=", ".join(names.model_fields),
            remedy=f"Write {near[0]}" if near else "Take it out",
            file=file,
            section=section,
            key=key,
        )
    if fault["type"] == "missing":
        return SettingsError(
            f"{where} is missing",
            remedy=f"Add {key} = … to [{section}]",
            file=file,
            section=section,
            key=key,
        )
    value = fault["input"]
    said = str(value).lower() if isinstance(value, bool) else described(value)
    expected = _expected(fault, names.model_fields.get(key))
    remedy = _remedy(fault, expected)
    return SettingsError(
        f"{where} = {said}",
        expected=expected,
        remedy=remedy,
        file=file,
        section=section,
        key=key,
    )


def _expected(fault, known):
    if known is not None and known.description:
        return known.description
    said = fault["msg"].removeprefix("Value error, ").removeprefix("Input should be ")
    return f"{said[:1].lower()}{said[1:]}"


def _remedy(fault, expected):
    value = fault["input"]
    if fault["type"] == "literal_error":
        allowed = fault["ctx"]["expected"].replace("'", "").replace(" or ", ", ")
        near = get_close_matches(described(value).casefold(), allowed.split(", "), n=1)
        return f"Write {near[0]!r}" if near else _decimal_point(value)
    if fault["type"] == "less_than_equal" and "metres" in expected.split():
        return "Did you give millimetres?"
    if fault["type"] == "float_type" and isinstance(value, str):
        return "Take the quotes away" if is_number(value) else _decimal_point(value)
    return ""


def _decimal_point(value):
    """Say how a number with a comma is written."""
    is_comma = isinstance(value, str) and "," in value
    return describe_fault(value, "")[2] if is_comma else ""


__all__ = ["Field", "Settings", "checked", "setting_problem"]
