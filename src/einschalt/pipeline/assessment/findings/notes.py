"""What was ignored, filled in or reprojected while reading."""

from einschalt.pipeline.assessment.finding import Finding, Gravity, Subject


def notes_of_reading(examined):
    """A finding for each note of the block."""
    return tuple(
        Finding("note_of_reading", Subject.BLOCK, Gravity.NOTE, facts={"note": note})
        for note in examined.block.notes
    )


TWO_STEP = SIMULTANEOUS = (notes_of_reading,)
