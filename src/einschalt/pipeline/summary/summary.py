"""What print(result) shows: the verdict, problems and suggestions, then the numbers."""

from einschalt.foundations.typesetting import seconds, wrapped
from einschalt.pipeline.summary.sections import (
    claim,
    control_strain,
    distribution,
    error_sources,
    flights,
    iterations,
    known_points,
    model_deformation,
    neighbours,
    patterns,
    precision,
    repeated_settings,
    tolerance,
)
from einschalt.pipeline.summary.sections.verdict import verdict
from einschalt.pipeline.summary.suggestions.catalogue import find_suggestions

UNBROKEN = "\N{NO-BREAK SPACE}=\N{NO-BREAK SPACE}"
SECTIONS = (
    precision,
    claim,
    error_sources,
    iterations,
    neighbours,
    known_points,
    tolerance,
    model_deformation,
    control_strain,
    distribution,
    flights,
    repeated_settings,
    patterns,
)
"""Modules whose ``section(result)`` makes a part of summary.txt, in their order."""


def summarize(result) -> str:
    """Write the text of ``print(result)``.

    Parameters
    ----------
    result : DensificationResult

    Returns
    -------
    str
        That of :func:`lasting_summary`, and how long the block took.
    """
    return f"{lasting_summary(result)}Computed in {seconds(result.seconds)}.\n"


def lasting_summary(result) -> str:
    """Write the text of summary.txt: the same for every run of a block.

    Parameters
    ----------
    result : DensificationResult

    Returns
    -------
    str
        First line the verdict, then "Problems and suggestions", then tables.
    """
    parts = [
        verdict(result),
        _suggestions(find_suggestions(result)),
        *(module.section(result).text() for module in SECTIONS),
        settings_line(result),
    ]
    return "\n\n".join(part for part in parts if part) + "\n"


def _suggestions(suggestions):
    lines = ["Problems and suggestions"]
    if not suggestions:
        lines.append("  none")
    for suggestion in suggestions:
        lines.append(wrapped(str(suggestion), first="  - ", indent="    "))
        lines += [
            wrapped(detail, first="      ", indent="        ")
            for detail in suggestion.details
        ]
    return "\n".join(lines)


def settings_line(result) -> str:
    """Say what settings differ from the defaults."""
    settings = result.settings
    chosen = [
        f"{key}{UNBROKEN}{value}"
        for key, value in settings.model_dump().items()
        if value != type(settings).model_fields[key].default
    ]
    said = f"{', '.join(chosen)}, others as by default" if chosen else "all defaults"
    return wrapped(f"Settings: {said}.").replace(UNBROKEN, " = ")
