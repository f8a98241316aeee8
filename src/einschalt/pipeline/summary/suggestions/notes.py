"""What to say of what was ignored, filled in or reprojected while reading."""

from einschalt.foundations.display_names import printable
from einschalt.pipeline.summary.suggestion import Suggestion


def note_of_reading(finding):
    """The note itself."""
    return Suggestion(printable(finding.facts["note"]).strip().rstrip("."))


WORDS = {"note_of_reading": note_of_reading}
