"""What was ignored, filled in or reprojected while reading."""

from einschalt.pipeline.assessment.findings.kinds import finding


def notes_of_reading(examined):
    """A finding for each note of the block."""
    notes = examined.block.notes
    return tuple(finding("note_of_reading", facts={"note": note}) for note in notes)


TWO_STEP = SIMULTANEOUS = (notes_of_reading,)
