"""How errors of image points reach the points of models that are formed of them.

A point of a model moves with its own four image coordinates, and with those of all
points of the model through its orientation. Neighbouring models share a photograph, and
with it the errors of its points: so the sources are image points, not model points.

See docs/theory/propagation.md.
"""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from einschalt.foundations.names import encode, encode_pairs, pair_up

if TYPE_CHECKING:
    from einschalt.stages.relative_orientation.image_orientation import ImageInfluence

SIDES = ("left_image", "right_image")


@dataclass(frozen=True, eq=False)
class ImageErrors:
    """Errors of image points behind the points of models."""

    influence: (
        "ImageInfluence"  # row for row as the model points, lengths in their unit
    )
    # (n_points, 2): rows of the left and the right one in the table of image points
    sources: np.ndarray
    n_sources: int  # rows of that table
    pairs: pd.DataFrame  # coverage, model_id, right_image, oriented or not

    @property
    def n_models(self) -> int:
        """Number of pairs."""
        return len(self.pairs)

    def of_rows(self, is_kept: np.ndarray) -> "ImageErrors":
        """Those of some of the points, of models that are kept whole."""
        found = self.influence
        influence = replace(
            found,
            model=found.model[is_kept],
            by_image=found.by_image[is_kept],
            gain=found.gain[is_kept],
            by_point=found.by_point[is_kept],
        )
        return replace(self, influence=influence, sources=self.sources[is_kept])


def image_errors(oriented, flight, enlargement) -> ImageErrors:
    """Find the image points behind all model points of a flight.

    ``enlargement`` (n_points,) leads from the unit of the base to that of the points.
    """
    points, models = oriented.model_points, flight.models
    table = flight.image_points
    known = encode_pairs(table["image_id"], table["point_id"])
    row_of = np.empty(len(known), dtype=np.int64)
    row_of[known.codes] = np.arange(len(table))
    names = encode_pairs(models["coverage"], models["model_id"])
    row_of_model = np.empty(len(names), dtype=np.int64)
    row_of_model[names.codes] = np.arange(len(models))
    asked = encode_pairs(points["coverage"], points["model_id"])
    place = row_of_model[names.locate(asked)[asked.codes]]
    point = encode(points["point_id"])
    sources = []
    for side in SIDES:
        image = encode(models[side].to_numpy(dtype=object)[place])
        wanted = pair_up(image, point)
        sources.append(row_of[known.locate(wanted)[wanted.codes]])
    found, stretch = oriented.image_influence, enlargement[:, None, None]
    of_pair = np.ones(len(oriented.models))
    of_pair[found.model] = enlargement
    # imported where photographs are oriented: other blocks do not wait for it
    from einschalt.stages.relative_orientation.image_orientation import (  # noqa: PLC0415
        ImageInfluence,
    )

    influence = ImageInfluence(
        found.model,
        found.by_image * stretch,
        found.gain * stretch,
        found.by_point,
        found.centres * of_pair[:, None, None, None],
    )
    names = ["coverage", "model_id"]
    pairs = oriented.models[names].merge(models[[*names, "right_image"]], on=names)
    return ImageErrors(influence, np.column_stack(sources), len(table), pairs)
