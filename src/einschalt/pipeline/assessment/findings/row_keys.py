"""Names in findings: plain texts, the first hundred of many."""

MOST_NAMED = 100
MODEL = ("flight", "model_id")
OBSERVATION = ("flight", "coverage", "model_id", "point_id")


def first_names(ids) -> tuple[str, ...]:
    """Take the first names of many, at most MOST_NAMED."""
    return tuple(str(name) for name in list(ids)[:MOST_NAMED])


def row_keys(rows, columns=OBSERVATION) -> tuple[tuple[str, ...], ...]:
    """Take what names the first rows of a table, at most MOST_NAMED."""
    first = rows[list(columns)].head(MOST_NAMED)
    return tuple(
        tuple(map(str, row)) for row in first.itertuples(index=False, name=None)
    )
