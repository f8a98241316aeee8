"""The title block of a report: what it is of, by whom, when, and from what."""

from einschalt.foundations.display_names import printable
from einschalt.foundations.language import mark_each, translated
from einschalt.foundations.projections import read_crs
from einschalt.interfaces.provenance import created_now, digest_of_inputs, version

METHODS = mark_each(
    {
        "from_high_flight": "two steps (high flight, then low flight)",
        "from_given_points": "two steps (given approximate points, then low flight)",
        "simultaneous": "simultaneous adjustment of all flights",
    }
)
LONGEST_NAME = 60


def title_block(result) -> list[tuple[str, str]]:
    """Facts that authorities want at the head of a report, each with its title."""
    block, empty = result.block, translated("not given")
    # project and operator as on a form, filled in or not
    facts = [
        (translated("Project"), block.project or empty),
        (translated("Block"), block.name),
        (translated("Operator"), block.operator or empty),
        (translated("Date"), created_now()[:10]),
        (translated("Reference system"), system_text(result.crs)),
        (translated("Method"), _method(result)),
        (translated("Settings"), _settings(result)),
        (translated("Computed by"), f"einschalt {version()}"),
        (translated("Checksum of the input"), digest_of_inputs(block)),
    ]
    return [(title, printable(fact)) for title, fact in facts if fact]


def system_text(crs):
    """Name and code of a reference system; what is known of it.

    >>> system_text("EPSG:31255")
    'MGI / Austria GK Central (EPSG:31255)'
    """
    if crs is None:
        return translated("not given")
    name = read_crs(crs).name
    text = str(crs)
    return f"{name} ({text})" if len(text) <= LONGEST_NAME else name


def _method(result):
    """Which way the points were computed: as the solution has gone it."""
    way = "from_high_flight" if result.block.high_flight else "from_given_points"
    way = way if result.simultaneous is None else "simultaneous"
    method = translated(METHODS[way])
    if result.choice is None:
        return method
    return translated("{method}, chosen by auto", method=method)


def _settings(result):
    """Which settings differ from the defaults."""
    chosen = result.assessment.block.chosen_settings
    if not chosen:
        return translated("all defaults")
    listed = ", ".join(f"{name} = {value}" for name, value in chosen)
    return translated("{chosen}; others default", chosen=listed)
