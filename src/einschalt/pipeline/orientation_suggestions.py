"""Suggestions on relative orientations: no convergence, dangerous surfaces."""

import numpy as np

from einschalt.foundations.typesetting import count, fixed, names, shortened
from einschalt.pipeline.suggestion import SIGNIFICANCE, Suggestion

MEASURE_ELSEWHERE = "Measure points in them that lie higher or lower, or farther apart"
WORST_FIRST = ("critical", "weak")


def orientations_without_convergence(result):
    """Models whose relative orientation did not come to rest."""
    rows = result.orientations
    if rows.empty:
        return None
    open_ones = rows[~rows["is_converged"].astype(bool)]
    if open_ones.empty:
        return None
    return Suggestion(
        f"{count(len(open_ones), 'model')} with a relative orientation that did not "
        f"converge: {_models(open_ones)}",
        "Look for gross errors in their image coordinates or y-parallaxes",
    )


def models_near_a_dangerous_surface(result):
    """Models whose points hardly determine their relative orientation."""
    rows = result.orientations
    if rows.empty:
        return None
    rows = rows[rows["is_converged"].astype(bool)]
    by_verdict = [rows[rows["verdict"] == verdict] for verdict in WORST_FIRST]
    parts = [
        f"{count(len(part), 'model')} {verdict} ({_models(part)})"
        for verdict, part in zip(WORST_FIRST, by_verdict, strict=True)
        if len(part)
    ]
    if not parts:
        return None
    inflation = max(part["inflation"].max() for part in by_verdict if len(part))
    uncertain = f"up to {fixed(inflation, 1)} times as uncertain as on flat terrain"
    # where the points determine nothing the factor is infinite
    known = uncertain if np.isfinite(inflation) else "not determined"
    return Suggestion(
        f"Relative orientation near a dangerous surface: {', '.join(parts)}; omega is "
        f"{known}",
        MEASURE_ELSEWHERE,
    )


def image_points_that_contradict(result):
    """Image points that contradict their pair, and what was done with them."""
    rows = result.orientation_residuals
    if "is_suspect" not in rows or not rows["is_suspect"].any():
        return None
    p_value = rows["p_value"].to_numpy(dtype=float)
    # a suspect of one pair in a thousand is chance: the worst must stand out of all
    if np.nanmin(p_value) * np.isfinite(p_value).sum() > SIGNIFICANCE:
        return None
    suspects = rows[rows["is_suspect"]].sort_values("p_value", kind="stable")
    shown = names(
        [
            f"{flight.removesuffix('_flight')} {shortened(model)} {shortened(point)}"
            for flight, model, point in zip(
                suspects["flight"],
                suspects["model_id"],
                suspects["point_id"],
                strict=True,
            )
        ],
        4,
    )
    done = {
        "keep": 'Measure them again, or set outliers = "snoop"',
        "snoop": "They were taken out of the orientation: measure them again",
    }
    return Suggestion(
        f"{count(len(suspects), 'image point')} that contradict their pair, worst "
        f"first (flight, model, point): {shown}",
        done.get(
            result.settings.outliers,
            "They have less weight in the orientation: measure them again",
        ),
    )


def _models(rows):
    shown = [
        f"{flight.removesuffix('_flight')} {shortened(model_id)}"
        for flight, model_id in zip(rows["flight"], rows["model_id"], strict=True)
    ]
    return names(shown)
