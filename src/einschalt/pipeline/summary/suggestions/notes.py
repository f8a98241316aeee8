"""What to say of what was ignored, filled in or reprojected while reading."""

from einschalt.foundations.display_names import printable
from einschalt.foundations.kept_texts import retold


def note_of_reading(finding):
    """The note itself."""
    return retold(printable(finding.facts["note"])).strip().rstrip(".")


REMEDIES = {}
WORDS = {"note_of_reading": note_of_reading}
