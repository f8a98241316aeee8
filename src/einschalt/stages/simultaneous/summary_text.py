"""What a simultaneous adjustment says of itself."""

import numpy as np

from einschalt.foundations import typesetting
from einschalt.foundations.errors import name_some
from einschalt.foundations.kept_texts import retold
from einschalt.foundations.language import mark, translated


def summary_text(adjustment) -> str:
    """Say how good the points are, and what contradicts."""
    points, models = adjustment.points, adjustment.models
    done = translated(
        "simultaneous adjustment of {models:model|models}, "
        "{points:point|points}, redundancy {redundancy}",
        models=int(models["is_usable"].sum()),
        points=len(points),
        redundancy=adjustment.redundancy,
    )
    s_0 = translated(
        "s_0 = {s_0} (1 where the errors are as large as given)",
        s_0=typesetting.number(adjustment.s_0),
    )
    new, check = (points[points["role"] == role] for role in ("new", "check"))
    errors = {
        mark("{n:new point|new points}, {size} (total, RMS)"): new[
            ["standard_error_total"]
        ],
        mark("{n:check point|check points} off by {size} (total, RMS)"): check[
            ["difference_easting", "difference_northing"]
        ],
    }
    sizes = [
        translated(message, n=len(rows), size=typesetting.length(_rms(rows)))
        for message, rows in errors.items()
        if len(rows)
    ]
    return "\n".join([done, s_0, *sizes, *_contradictions(adjustment)])


def _contradictions(adjustment):
    """What control disagrees, and which models could not be determined."""
    lines = []
    suspects = adjustment.control[adjustment.control["is_suspect"]]
    if len(suspects):
        message = mark(
            "{n} of {n_all:control point|control points} disagree with the block: "
            "{names}"
        )
        if suspects["is_set_aside"].any():
            message = mark(
                "{n} of {n_all:control point|control points} disagree with the "
                "block and are set aside: {names}"
            )
        names = retold(name_some(suspects["point_id"]))
        counted = {"n": len(suspects), "n_all": len(adjustment.control)}
        lines.append(translated(message, **counted, names=names))
    if len(adjustment.failures):
        lines.append(
            translated(
                "{n} of {n_all:model|models} could not be determined: {reason}",
                n=len(adjustment.failures),
                n_all=len(adjustment.models),
                reason=retold(str(adjustment.failures["reason"].iloc[0])),
            )
        )
    return lines


def _rms(parts):
    """Root mean square of lengths that a table holds by their parts [m]."""
    return float(np.sqrt(np.mean((parts**2).sum(axis=1))))
