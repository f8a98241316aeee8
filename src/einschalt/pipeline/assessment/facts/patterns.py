"""Affinity of film and strain of the control network: what was looked for and found."""

from dataclasses import dataclass, replace
from enum import StrEnum

from einschalt.pipeline.assessment.evidence.systematic_errors import (
    SystematicPatterns,
    beyond_strain_test,
)


class NoStrainTest(StrEnum):
    """Why strain of control was not looked for."""

    ORIENTATIONS_BEND = "errors of orientations bend models"
    ORIENTATIONS_BEND_WEIGHED = "and the simultaneous adjustment knows their size"
    TOO_LARGE = "the block is too large"


@dataclass(frozen=True)
class PatternFacts:
    """What was found, and why strain was not looked for."""

    patterns: SystematicPatterns
    # None where strain was tested, or where there is no reason to be told
    untested: NoStrainTest | None = None
    size: str = ""  # of a block that is too large


def pattern_facts(examined) -> PatternFacts:
    """Collect the systematic patterns of a block."""
    patterns = examined.patterns
    if patterns.strain is not None:
        return PatternFacts(replace(patterns, strain=examined.strain))
    if any(examined.orientation_errors.values()):
        has_images = any(f.has_images for f in examined.block.flights.values())
        return PatternFacts(
            patterns,
            NoStrainTest.ORIENTATIONS_BEND
            if has_images
            else NoStrainTest.ORIENTATIONS_BEND_WEIGHED,
        )
    size = beyond_strain_test(examined)
    return PatternFacts(patterns, NoStrainTest.TOO_LARGE if size else None, size)
