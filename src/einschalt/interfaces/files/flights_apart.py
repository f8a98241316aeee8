"""Two flights in one table: a column that no table of a block has tells them apart.

Models of both flights often have the same names. Where they have not, the table looks
like that of one flight, whose models have two scales.
"""

from einschalt.foundations.column_words import folded
from einschalt.foundations.display_names import shortened
from einschalt.foundations.errors import TableError, name_some

# what has one value in a flight, in English, German, French, Italian and Spanish
OF_FLIGHTS = {
    *("flight", "flightname", "flightno", "flightid", "mission", "flyingheight"),
    *("scale", "imagescale", "photoscale", "scalenumber"),
    *("flug", "flugname", "flugnr", "flugnummer", "bildflug"),
    *("flughoehe", "massstab", "bildmassstab", "massstabszahl", "bildmassstabszahl"),
    *("vol", "nomduvol", "hauteurdevol", "echelle", "volo", "quotadivolo", "scala"),
    *("vuelo", "escala"),
}
N_FLIGHTS = 2


def require_one_flight(frame, schema, source):
    """Refuse a table of models or photographs that has a column of two flights."""
    if not {"model_id", "image_id"}.intersection(schema.key):
        return
    for name in frame.columns:
        is_known = name in schema.names or list(frame.columns).count(name) != 1
        if is_known or folded(name) not in OF_FLIGHTS:
            continue
        given = [str(value).strip() for value in frame[name].dropna().unique()]
        given = sorted({value for value in given if value})
        if len(given) == N_FLIGHTS:
            raise _two_flights(str(name), given, source)


def _two_flights(name, given, source):
    values = name_some([shortened(value) for value in given])
    return TableError(
        f"column '{shortened(name)}' has the values {values}, as of two flights",
        expected="one flight in each table",
        remedy="Part the rows into a file for each flight; rename the column if it "
        "tells other things apart",
        file=source,
    )
