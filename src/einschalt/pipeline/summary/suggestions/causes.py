"""The words for causes: what explains other findings."""

from einschalt.foundations.display_names import shortened
from einschalt.foundations.typesetting import count, length
from einschalt.pipeline.summary.suggestion import Suggestion
from einschalt.pipeline.summary.wording import flight_name

MOST_SHOWN = 4
REMEDIES = {"put_the_names_right": "Put the names right and compute again"}


def exchanged_names(finding):
    """Pairs of points that were measured under each other's name."""
    exchanges = finding.facts["exchanges"]
    shown = [_exchange(exchange) for exchange in exchanges[:MOST_SHOWN]]
    n_more = finding.facts["n_exchanges"] - len(shown)
    if n_more > 0:
        shown.append(f"and {count(n_more, 'further pair')}")
    return Suggestion(
        f"Exchanged names: {'; '.join(shown)}",
        REMEDIES[finding.remedy],
        details=_explained(finding.facts["explains"]),
    )


def _exchange(facts):
    one, other = (shortened(point) for point in facts["points"])
    return (
        f"{one} and {other} in {flight_name(facts['flight'])} model "
        f"{shortened(facts['model_id'])}, coverage {facts['coverage']}: with the names "
        f"put right its m_0 is {length(facts['m_0_exchanged'])} instead of "
        f"{length(facts['m_0'])}"
    )


def _explained(codes):
    """What follows from the cause, by name: more words would repeat it."""
    if not codes:
        return ()
    said = "; ".join(_title(code) for code in dict.fromkeys(codes))
    consequences = f"{count(len(codes), 'further finding')} may follow from it: {said}"
    return (f"{consequences}. Other faults may hide behind it until it is mended.",)


def _title(code):
    return code.replace("_", " ").replace("m 0", "m_0")


WORDS = {"exchanged_names": exchanged_names}
