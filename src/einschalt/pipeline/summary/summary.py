"""What print(result) shows: the verdict, problems and suggestions, then the numbers."""

from einschalt.foundations.language import translated
from einschalt.foundations.typesetting import seconds, wrapped
from einschalt.pipeline.summary.section import Section
from einschalt.pipeline.summary.sections import (
    claim,
    control_strain,
    error_sources,
    flights,
    known_points,
    model_deformation,
    moves,
    neighbours,
    patterns,
    precision,
    repeated_settings,
    tolerance,
)
from einschalt.pipeline.summary.suggestions.catalogue import notes_of, suggestions_of
from einschalt.pipeline.summary.verdict import verdict

UNBROKEN = "\N{NO-BREAK SPACE}=\N{NO-BREAK SPACE}"


def sections(assessment) -> dict[str, Section]:
    """Set all sections, in their order; those without rows have nothing to tell."""
    told = assessment
    return {
        "precision": precision.section(
            told.precision,
            told.credible,
            told.credible_heights,
            is_untried=told.is_untried,
        ),
        "ways": precision.ways(told.choice),
        "claim": claim.section(told.claim),
        "height_claim": claim.heights(told.height_claim),
        "error_sources": error_sources.section(told.error_sources),
        "iterations": moves.iterations(told.iterations),
        "neighbours": neighbours.section(told.neighbours),
        "known_points": known_points.section(told.known_points),
        "tolerance": tolerance.section(told.tolerance, told.credible),
        "deformation": model_deformation.section(told.deformation, told.better),
        "own_deformation": model_deformation.own_section(told.deformation, told.better),
        "control_strain": control_strain.section(told.control_strain),
        "distribution": moves.distribution(told.distribution),
        "flights": flights.section(told.flights, told.approximations),
        "repeated_settings": repeated_settings.section(told.repeated_settings),
        "patterns": patterns.section(told.patterns),
    }


def summarize(result) -> str:
    """Write the text of ``print(result)``."""
    text = lasting_summary(result.assessment)
    computed = translated("Computed in {time}.", time=seconds(result.seconds))
    return f"{text}{computed}\n"


def lasting_summary(assessment) -> str:
    """Write the text of summary.txt: the same for every run of a block.

    First line the verdict, then "Problems and suggestions", then tables, and what was
    noted while the block was read.
    """
    parts = [
        verdict(assessment),
        _suggestions(suggestions_of(assessment.findings)),
        *(section.text() for section in sections(assessment).values()),
        _notes(notes_of(assessment.findings)),
        settings_line(assessment.block.chosen_settings),
    ]
    return "\n\n".join(part for part in parts if part) + "\n"


def _suggestions(suggestions):
    lines = [translated("Problems and suggestions")]
    if not suggestions:
        lines.append(f"  {translated('none')}")
    for suggestion in suggestions:
        lines.append(wrapped(str(suggestion), first="  - ", indent="    "))
        lines += [
            wrapped(detail, first="      ", indent="        ")
            for detail in suggestion.details
        ]
    return "\n".join(lines)


def _notes(notes):
    lines = [wrapped(str(note), first="  - ", indent="    ") for note in notes]
    return "\n".join([translated("Notes on reading"), *lines]) if lines else ""


def settings_line(chosen_settings) -> str:
    """Say what settings differ from the defaults."""
    chosen = [f"{key}{UNBROKEN}{value}" for key, value in chosen_settings]
    if not chosen:
        return translated("Settings: all defaults.")
    message = translated(
        "Settings: {chosen}, others default.", chosen=", ".join(chosen)
    )
    return wrapped(message).replace(UNBROKEN, " = ")
