"""One frozen Settings: how a block is computed, checked on construction."""

import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from math import inf, isfinite
from numbers import Real
from typing import Annotated, Any, Literal, Never, Self, get_args

from pydantic import BaseModel, ConfigDict, Field, ValidationError, field_validator
from pydantic_core import PydanticCustomError

from einschalt.foundations.display_names import shortened
from einschalt.foundations.errors import BlockError, SettingsError
from einschalt.foundations.near_words import nearest
from einschalt.foundations.number_parsing import (
    describe_fault,
    is_number,
    plain_integer,
)
from einschalt.foundations.value_descriptions import described
from einschalt.theory.adjustment.significance import GROSS_ERROR_SIGNIFICANCE

NO_TOLERANCE = "none"
TOLERANCES = (NO_TOLERANCE, "vermv_1994", "vermv_2010", "vermv_2016")
LARGEST_TOLERANCE = 10.0  # metres
# words that earlier versions wrote, and what they are called now
FORMER_WORDS = {"method": {"pipeline": "two_step"}}


@dataclass(frozen=True)
class Expected:
    """What a field takes, as messages say it; stands in the field's annotation."""

    text: str


Probability = Annotated[float, Expected("a probability above 0 and below 1")]


class Settings(BaseModel):
    """How a block is computed; every field has a default.

    Attributes
    ----------
    method : {"two_step", "simultaneous", "auto"}
        The two-step method of Kovarik 1971, or all models of all flights and the
        control in one adjustment. Earlier versions called the former "pipeline"; that
        word is still accepted, with a DeprecationWarning.
    coverage_mean : {"all", "most_central"}
        Which models give a point's coordinates: every model that contains it, or, as in
        1971, per coverage the model in which ``max(|u|, |v|)`` is smallest, u and v
        being the position in the model's extent.
    weighting : {"auto", "plain", "weighted", "rigorous"}
        Arithmetic mean; weights 1 / M² with the M of the error budget; or, if the
        size of every error is known, the mean of least variance by the propagated
        covariances of a point's values, which a badly determined model does not spoil.
        "auto" is "rigorous" if that is possible and all models are used, otherwise
        "plain".
    outliers : {"keep", "snoop", "huber", "tukey"}
        Treatment of gross errors: they are only reported; the worst of each low-flight
        model is removed until none is left; or a robust norm gives them less weight.
        Unless they are kept, measurements of either flight that contradict the other
        models of their flight in a simultaneous adjustment take no part, and the value
        of a suspect does not enter the mean of its point if another model has a value
        that is not suspect.
    screening : {"propagated", "practice_1968", "off"}
        Limit for the differences of a point's coverages: from the propagated precision
        of the difference, or, as in the double coverages of 1968, three standard errors
        estimated from all differences. A suspect keeps the values of its coverages
        beside their mean.
    iterations : int
        Maximum number of iterations: the low flight is transformed again onto its own
        improved coordinates, with control points held, until nothing moves by 1 mm.
    model_deformation : {"modelled", "tested", "ignored"}
        Whether deformations of models are modelled if a test finds them, only tested,
        or neither: those of single models, and with ``method = "simultaneous"`` also
        those that all models of a flight share.
    earth_curvature : {"treated", "ignored"}
        Whether models are corrected for the curvature of the Earth and the scale of the
        map, if the block has a projected system: spatial models always, plane ones for
        the scale if its change across them amounts to a millimetre. Use "ignored" if
        the measuring program has already corrected them, or if they are maps.
    variance_components : {"given", "estimated"}
        With ``method = "simultaneous"``: whether the errors of control and flights are
        those given, or are estimated from their residuals.
    significance : float
        Probability that a model without gross errors has a suspect residual, and
        that a point without gross errors is suspected because of its coverages.
    residual_distribution : {"none", "natural_neighbour", "inverse_distance", \
            "multiquadric"}
        How the residuals of control points are distributed to the points between, if
        these must fit an existing cadastre: control then keeps its given coordinates.

    tolerance : {"none", "vermv_1994", "vermv_2010", "vermv_2016"} or float
        Largest standard error, TOTAL [m], that a point may have: that of an Austrian
        surveying ordinance, or any other. Every point then passes or fails.
    confidence : float
        Probability that the ellipse of a point contains the true point; 0.393 gives
        the mean error ellipse.

    crs_accuracy_m : float, optional
        Worst accuracy [m] of an operation that transforms points to the system of the
        block; by default a quarter of their standard error.
    crs_operation : str
        The operation to be used whatever its accuracy: its name in PROJ, a part of it,
        or its EPSG code; for several pairs of systems that of each, separated by ";".
    crs_epoch : float, optional
        Epoch of the coordinates, a decimal year such as 2020.5: for operations between
        frames that move relative to each other, as ITRF2014 and the systems that are
        fixed to a plate.
    output_crs : str
        System of the results, if it is not that of the block.
    grids : str
        Folder with grids for PROJ, in addition to its own; relative to the folder of
        the block.

    Raises
    ------
    SettingsError
        A field is unknown or its value is not allowed.

    Examples
    --------
    >>> Settings(coverage_mean="most_central").weighting
    'auto'
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    method: Literal["two_step", "simultaneous", "auto"] = Field(
        "two_step",
        description="The two-step method of 1971, or all models of all flights in "
        "one adjustment; auto computes both, and selects the one that the "
        "measurements support best.",
    )
    coverage_mean: Literal["all", "most_central"] = Field(
        "all",
        description="Values that form the mean of a point: from every model, or per "
        "coverage from the most central one (1971).",
    )
    weighting: Literal["auto", "plain", "weighted", "rigorous"] = Field(
        "auto",
        description="Mean of a point's values: arithmetic, with weights 1 / M², or "
        "with least variance by their propagated covariances; auto is the last if "
        "these are known and coverage_mean is all, otherwise the first.",
    )
    outliers: Literal["keep", "snoop", "huber", "tukey"] = Field(
        "keep",
        description="Gross errors of the low flight: only reported, removed one by "
        "one, or given less weight by a robust norm.",
    )
    screening: Literal["propagated", "practice_1968", "off"] = Field(
        "propagated",
        description="Limits of the differences of a point's coverages: from the "
        "propagated precision, three standard errors as in 1968, or none.",
    )
    iterations: Annotated[int, Expected("a whole number from 1 to 100")] = Field(
        1,
        ge=1,
        le=100,
        strict=True,
        description="Maximum number of iterations: the low flight is transformed "
        "again onto its own improved coordinates, with control held.",
    )
    model_deformation: Literal["modelled", "tested", "ignored"] = Field(
        "modelled",
        description="Deformations of models: modelled if a test finds them, only "
        "tested, or neither; those of single models, and with method simultaneous "
        "also those that all models of a flight share.",
    )
    earth_curvature: Literal["treated", "ignored"] = Field(
        "treated",
        description="Curvature of the Earth and scale of the map in models; use "
        "ignored if their coordinates were already corrected for it.",
    )
    variance_components: Literal["given", "estimated"] = Field(
        "given",
        description="With method simultaneous: errors of control and flights as "
        "given, or as estimated from the residuals.",
    )
    significance: Probability = Field(
        GROSS_ERROR_SIGNIFICANCE,
        gt=0.0,
        lt=1.0,
        description="Probability that a model or point without gross errors is "
        "reported as suspect.",
    )
    residual_distribution: Literal[
        "none", "natural_neighbour", "inverse_distance", "multiquadric"
    ] = Field(
        "none",
        description="Distribute the residuals of control points to the points "
        "between them, if these must fit an existing cadastre.",
    )
    tolerance: Annotated[
        str | float,
        Expected(
            f"{', '.join(TOLERANCES)}, or a number of metres above 0, at most "
            f"{LARGEST_TOLERANCE:g}"
        ),
    ] = Field(
        NO_TOLERANCE,
        description="Total standard error that a point may have: metres, or "
        f"{', '.join(TOLERANCES)}.",
    )
    confidence: Probability = Field(
        0.95,
        gt=0.0,
        lt=1.0,
        description="Probability that a confidence ellipse contains the true point.",
    )

    crs_accuracy_m: Annotated[
        float | None, Expected("a number of metres above 0, at most 100")
    ] = Field(
        None,
        gt=0.0,
        le=100.0,
        description="Worst accuracy of an operation between reference systems, "
        "metres; if omitted, a quarter of the standard error of the points.",
    )
    crs_operation: Annotated[str, Expected("a text, such as EPSG:1619")] = Field(
        "",
        description="Operation between reference systems, whatever its accuracy: its "
        "name in PROJ, a part of it, or its EPSG code.",
    )
    crs_epoch: Annotated[
        float | None, Expected("a decimal year from 1900 to 2100, such as 2020.5")
    ] = Field(
        None,
        ge=1900.0,
        le=2100.0,
        description="Epoch of the coordinates, a decimal year: if their frame moves "
        "relative to that of the block, as ITRF2014 does.",
    )
    output_crs: Annotated[str, Expected("a text, such as EPSG:25833")] = Field(
        "",
        description="Reference system of the results, if it is not that of the block.",
    )
    grids: Annotated[str, Expected("a text: the path of a folder")] = Field(
        "",
        description="Folder with grids of the reference systems, in addition to "
        "those of PROJ.",
    )

    def __init__(self, *unnamed: Never, **fields: Any) -> None:
        if unnamed:
            of_dict = "Write Settings(**fields) of a dict of fields"
            raise SettingsError(
                f"Settings was given {described(unnamed[0])} without a name",
                expected="fields by name, such as method=…",
                remedy=of_dict if isinstance(unnamed[0], Mapping) else "",
            )
        for key, former in FORMER_WORDS.items():
            word = fields.get(key)
            if isinstance(word, str) and word in former:
                warnings.warn(
                    f'{key} = "{word}" is now called "{former[word]}"',
                    DeprecationWarning,
                    stacklevel=2,
                )
        present = with_present_words(fields)
        checked(super().__init__, present, section="settings", names=type(self))

    @field_validator("iterations", mode="before")
    @classmethod
    def _integer_of_numpy(cls, value):
        return plain_integer(value)

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
        if not is_number_of or not 0.0 < metres < inf:
            raise PydanticCustomError("value_error", "no tolerance")
        if metres > LARGEST_TOLERANCE:
            raise PydanticCustomError("less_than_equal", "too large")
        return float(metres)

    def weighting_with(self, covariances_are_known: bool) -> str:
        """Weights of the values of a point, with or without known covariances."""
        if self.weighting != "auto":
            return self.weighting
        is_best = covariances_are_known and self.coverage_mean == "all"
        return "rigorous" if is_best else "plain"

    def updated(self, given: Mapping[str, Any]) -> Self:
        """Return the settings with some fields replaced, checked as on construction."""
        # the fields as they are: some may have been put there without a check
        return type(self)(**{**dict(self), **given})

    def model_copy(
        self, *, update: Mapping[str, Any] | None = None, deep: bool = False
    ) -> Self:
        """Return a copy; what is given in ``update`` is checked, as by :meth:`updated`.

        The copies of pydantic check nothing.
        """
        return self.updated(update) if update else super().model_copy(deep=deep)


def words_of(name):
    """Words that a field of Settings allows now; none for fields that take numbers.

    Examples
    --------
    >>> words_of("weighting"), words_of("confidence")
    (('auto', 'plain', 'weighted', 'rigorous'), ())
    """
    annotation = Settings.model_fields[name].annotation
    return tuple(word for word in get_args(annotation) if isinstance(word, str))


def with_present_words(fields):
    """Replace the words of earlier versions, as results of these have them.

    Examples
    --------
    >>> with_present_words({"method": "pipeline", "iterations": 2})
    {'method': 'two_step', 'iterations': 2}
    """
    present = dict(fields)
    for key, former in FORMER_WORDS.items():
        if isinstance(present.get(key), str):
            present[key] = former.get(present[key], present[key])
    return present


def checked(build, fields, *, section, names, file=None):
    """Build a pydantic model and say what is wrong in the words of the project.

    ``section`` of block.toml and ``file`` are said in messages; ``names`` is the model,
    for the nearest known name of an unknown key. Several faults come in a BlockError.
    """
    try:
        return build(**fields)
    except ValidationError as error:
        faults = error.errors()
    problems = [setting_problem(f, section, names, file=file) for f in faults]
    if len(problems) == 1:
        raise problems[0]
    raise BlockError(problems)


def setting_problem(fault, section, names, *, file=None):
    """Say in the words of the project what pydantic found.

    ``names`` is the model. What was expected is the field's Expected, the words of a
    choice, or the field's description.
    """
    key = ".".join(shortened(str(part)) for part in fault["loc"]) or section
    where = f"[{section}] {key}"
    problem = partial(SettingsError, file=file, section=section, key=key)
    if fault["type"] == "extra_forbidden":
        near = nearest(key, names.model_fields)
        remedy = f"Write {near}" if near else "Take it out"
        if key in Settings.model_fields:  # of another section, or of a camera's file
            remedy = "Write it below [settings] of block.toml"
        known = ", ".join(names.model_fields)
        return problem(f"{where}: unknown key", expected=known, remedy=remedy)
    if fault["type"] == "missing":
        return problem(f"{where} is missing", remedy=f"Add {key} = … to [{section}]")
    value = fault["input"]
    said = str(value).lower() if isinstance(value, bool) else described(value)
    expected = _expected(fault, names.model_fields.get(key))
    remedy = _remedy(fault, expected)
    return problem(f"{where} = {said}", expected=expected, remedy=remedy)


def _expected(fault, known):
    facts = [] if known is None else known.metadata
    expected = [fact.text for fact in facts if isinstance(fact, Expected)]
    if expected:
        return expected[0]
    # of a choice pydantic lists the words
    if fault["type"] != "literal_error" and known is not None and known.description:
        return known.description
    said = fault["msg"].removeprefix("Value error, ").removeprefix("Input should be ")
    return f"{said[:1].lower()}{said[1:]}"


def _remedy(fault, expected):
    value = fault["input"]
    if fault["type"] == "literal_error":
        allowed = fault["ctx"]["expected"].replace("'", "").replace(" or ", ", ")
        near = nearest(value, allowed.split(", "))
        return f"Write {near!r}" if near else _decimal_point(value)
    if fault["type"] == "less_than_equal" and "metres" in expected.split():
        is_finite = isinstance(value, int) or isfinite(float(value))
        return "Did you give millimetres?" if is_finite else "Give a number"
    if fault["type"] == "float_type" and isinstance(value, str):
        return "Take the quotes away" if is_number(value) else _decimal_point(value)
    return ""


def _decimal_point(value):
    """Say how a number with a comma is written."""
    is_comma = isinstance(value, str) and "," in value
    return describe_fault(value, "")[2] if is_comma else ""
