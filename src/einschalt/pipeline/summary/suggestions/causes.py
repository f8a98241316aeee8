"""The words for causes: what explains other findings."""

from math import isfinite

from einschalt.foundations.display_names import all_shortened, shortened
from einschalt.foundations.language import mark, mark_each, translated
from einschalt.foundations.typesetting import length
from einschalt.pipeline.summary.finding_titles import title_of
from einschalt.pipeline.summary.suggestion import Suggestion, filled
from einschalt.pipeline.summary.suggestions import suspects
from einschalt.pipeline.summary.wording import flight_name

MOST_SHOWN = 4
GROSS = mark(
    "{n_observations:count gross error} of up to {largest:length}, found by comparison "
    "with the other models of the flight and left in the computation, worst first "
    "(flight, coverage, model, point): {observations:observations of n_observations}"
)
UNDECIDED = mark(
    "Of {n_undecided:count point} all measurements of a flight are among them: they "
    "contradict each other, and nothing tells which of them is wrong: "
    "{undecided:names of n_undecided}."
)
REMEDIES = mark_each(
    {
        "put_the_names_right": "Correct the names and compute again",
        "compare_names_of_both_flights": (
            "All models that hold the first two points have them exchanged: so they "
            "may be exchanged there, or in what the models are fitted onto (the high "
            "flight, or the given coordinates). The measurements do not tell which: "
            "compare the points with their descriptions, and correct the names there"
        ),
        "compare_targets": (
            "Compare the targets in the photographs of both flights: measure the "
            "points again, or give them another name in one of the flights"
        ),
    }
)
TARGETS = mark(
    "{n_points:count point} found elsewhere by all models of the low flight than by "
    "the high flight, by up to {largest:length}: {names:names of n_points}. One of the "
    "flights measured another target, and nothing tells which"
)
TARGETS_OF_FLIGHT = mark(
    "{n_points:count point} found elsewhere by all models of the low flight than by "
    "the high flight, by up to {largest:length}: {names:names of n_points}. By the "
    "given coordinates the {flight:flight} measured another target"
)
EXCHANGE = mark(
    "{one} and {other} in {flight} model {model}, coverage {coverage}: with the names "
    "corrected its m_0 is {m_0_exchanged} instead of {m_0}"
)
CROSSED = mark(
    "{one} and {other} in {flight} model {model}, coverage {coverage}: with the names "
    "corrected they lie {m_0_exchanged} from where the other flight has them, instead "
    "of {m_0}"
)
MIXED = mark(
    "{names} in {flight} model {model}, coverage {coverage}: with the names corrected "
    "its m_0 is {m_0_exchanged} instead of {m_0}"
)
MEASURED_AS = mark("{name} measured as {other}")
SLIP = mark(
    "the names of {n:point|points} from {one} to {other} in {flight} model {model}, "
    "coverage {coverage}, have slipped by one row: with the names corrected its m_0 is "
    "{m_0_exchanged} instead of {m_0}"
)
IN_PHOTOGRAPH = mark(
    "{one} and {other} in photograph {image} of the {flight}: with the names corrected "
    "sigma_0 of model {model} is {after} instead of {before}"
)
IN_PHOTOGRAPH_OF_NO_MODEL = mark(
    "{one} and {other} in photograph {image} of the {flight}: with the names corrected "
    "sigma_0 of model {model} is {after}; as measured its relative orientation does "
    "not converge"
)
FURTHER_MODELS = mark("and {n:further model|further models}")
FURTHER_PAIRS = mark("and {n:further pair|further pairs}")
EXPLAINED = mark(
    "{n:further finding|further findings} may follow from it: {findings}. Other faults "
    "may hide behind it until it is corrected."
)


def exchanged_names(finding):
    """Models of which points were measured under each other's name."""
    return _exchanges(finding, _exchange, FURTHER_MODELS)


def exchanged_image_names(finding):
    """Pairs of points under each other's name in a photograph."""
    return _exchanges(finding, _in_photograph, FURTHER_PAIRS)


def _exchanges(finding, told, further):
    """Exchanged names, each as ``told`` words it, and what may follow from them."""
    shown = [told(exchange) for exchange in finding.facts["exchanges"][:MOST_SHOWN]]
    n_more = finding.facts["n_exchanges"] - len(shown)
    if n_more > 0:
        shown.append(translated(further, n=n_more))
    return Suggestion(
        translated("Exchanged names: {pairs}", pairs="; ".join(shown)),
        translated(REMEDIES[finding.remedy]),
        details=explained(finding.facts["explains"]),
    )


def _in_photograph(facts):
    one, other = all_shortened(facts["points"])
    image, *others = all_shortened(facts["images"])
    if others:  # nothing tells which of the two
        image = translated("{image} or {other}", image=image, other=others[0])
    is_known = isfinite(facts["sigma_0"])
    return translated(
        IN_PHOTOGRAPH if is_known else IN_PHOTOGRAPH_OF_NO_MODEL,
        one=one,
        other=other,
        image=image,
        flight=flight_name(facts["flight"]),
        model=shortened(facts["models"][0][1]),
        after=length(facts["sigma_0_exchanged"]),
        before=length(facts["sigma_0"]),
    )


def kept_gross_measurements(finding):
    """Gross errors that take part, and what is gone without them."""
    open_ones = ()
    if finding.facts["n_undecided"]:
        open_ones = (filled(UNDECIDED, finding),)
    return Suggestion(
        filled(GROSS, finding),
        translated(suspects.REMEDIES[finding.remedy]),
        details=(*open_ones, *explained(finding.facts["explains"])),
    )


def other_targets(finding):
    """Points that the flights have in different places, and which flight is wrong."""
    words = TARGETS_OF_FLIGHT if finding.facts["flight"] else TARGETS
    return Suggestion(
        filled(words, finding),
        translated(REMEDIES[finding.remedy]),
        details=explained(finding.facts["explains"]),
    )


def _exchange(facts):
    """A pair, names that have slipped, or names each with that of another point."""
    n_points = facts["n_points"]
    words = CROSSED if facts["is_by_other_flight"] else EXCHANGE
    one, *_, other = all_shortened((*facts["points"], facts["last"]))
    named = {"one": one, "other": other}
    if facts["is_slip"]:
        words, named = SLIP, {"n": n_points, **named}
    elif n_points > len(("one", "other")):
        words, named = MIXED, {"names": _each_as_measured(facts)}
    return translated(
        words,
        **named,
        flight=flight_name(facts["flight"]),
        model=shortened(facts["model_id"]),
        coverage=facts["coverage"],
        m_0_exchanged=length(facts["m_0_exchanged"]),
        m_0=length(facts["m_0"]),
    )


def _each_as_measured(facts):
    """Points, each with the name under which it was measured."""
    points = all_shortened(facts["points"])
    measured_as = all_shortened(facts["measured_as"])
    shown = [
        translated(MEASURED_AS, name=name, other=other)
        for name, other in zip(points, measured_as, strict=True)
    ]
    return ", ".join(shown)


def explained(codes):
    """What follows from the cause, by name: more words would repeat it."""
    if not codes:
        return ()
    titles = "; ".join(title_of(code) for code in dict.fromkeys(codes))
    return (translated(EXPLAINED, n=len(codes), findings=titles),)


WORDS = {
    "exchanged_image_names": exchanged_image_names,
    "exchanged_names": exchanged_names,
    "kept_gross_measurements": kept_gross_measurements,
    "other_targets": other_targets,
}
