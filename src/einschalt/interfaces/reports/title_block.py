"""The title block of a report: what it is of, by whom, when, and from what."""

from einschalt.foundations.display_names import printable
from einschalt.foundations.projections import read_crs
from einschalt.interfaces.provenance import created_now, digest_of_inputs, version

TWO_STEPS = "two steps ({}, then low flight)"
SIMULTANEOUS = "simultaneous adjustment of all flights"
LONGEST_NAME = 60


def title_block(result) -> list[tuple[str, str]]:
    """Facts that authorities want at the head of a report, each with its title."""
    block = result.block
    facts = [
        ("Project", block.project),
        ("Block", block.name),
        ("Operator", block.operator),
        ("Date", created_now()[:10]),
        ("Reference system", system_text(result.crs)),
        ("Method", _method(result)),
        ("Computed by", f"einschalt {version()}"),
        ("Checksum of the input", digest_of_inputs(block)),
    ]
    return [(title, printable(fact)) for title, fact in facts if fact]


def system_text(crs):
    """Name and code of a reference system; what is known of it.

    >>> system_text("EPSG:31255")
    'MGI / Austria GK Central (EPSG:31255)'
    """
    if crs is None:
        return "not given"
    name = read_crs(crs).name
    text = str(crs)
    return f"{name} ({text})" if len(text) <= LONGEST_NAME else name


def _method(result):
    """Which way the points were computed: as the solution has gone it."""
    first = "high flight" if result.block.high_flight else "given approximate points"
    said = TWO_STEPS.format(first) if result.simultaneous is None else SIMULTANEOUS
    return f"{said}, chosen by auto" if result.choice is not None else said
