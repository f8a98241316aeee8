"""What every name in assessment.json and provenance.json means."""
