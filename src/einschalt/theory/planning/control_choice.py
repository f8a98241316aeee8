"""Which points are control, so that every model has it where it wants it.

Places at which models want control are taken in turn. A point that was chosen before
serves, where it lies near enough; otherwise the nearest point of the model is chosen.
So neighbours share what they hold in common.
"""

import numpy as np

from einschalt.foundations.kernels import compiled


@compiled
def serving_points(
    point, start, position, centre, half, places, is_chosen, near_enough
):
    """Choose points until every model has one for each of its places.

    ``point`` (n_rows,): points of the models in turn, of which each has those from
    ``start[model]`` on, (n_models + 1,); ``position`` (n_points, 2), ``centre``
    (n_models, 2) and ``half`` (2,), half of a model along and across [m]; ``places``
    (n_places, 2), in halves from the centre. ``is_chosen`` (n_points,), the points
    that are chosen already, is written to. A point serves that is at most
    ``near_enough`` [halves] farther from the place than the nearest one, or than the
    place itself; and at one place of a model only. Models of fewer points than places
    want none.
    """
    n_places = len(places)
    for model in range(len(centre)):
        first, end = start[model], start[model + 1]
        if end - first < n_places:
            continue
        serves = np.zeros(end - first, dtype=np.bool_)
        reach = np.empty(end - first)
        for place in range(n_places):
            nearest = -1
            for k in range(end - first):
                if serves[k]:
                    continue
                at = position[point[first + k]]
                along = abs((at[0] - centre[model, 0]) / half[0] - places[place, 0])
                across = abs((at[1] - centre[model, 1]) / half[1] - places[place, 1])
                reach[k] = max(along, across)
                if nearest < 0 or reach[k] < reach[nearest]:
                    nearest = k
            allowed = max(near_enough, reach[nearest] + near_enough)
            one = -1
            for k in range(end - first):
                is_old = not serves[k] and is_chosen[point[first + k]]
                if (
                    is_old
                    and reach[k] <= allowed
                    and (one < 0 or reach[k] < reach[one])
                ):
                    one = k
            one = nearest if one < 0 else one
            serves[one] = True
            is_chosen[point[first + one]] = True
