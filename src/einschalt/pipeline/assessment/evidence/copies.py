"""Measurements that were given twice: a coverage or a flight that is a copy.

Two models, or photographs, in which the same points have the same coordinates to the
last digit were not measured apart: no operator sets a point twice without an error, and
no two models have the same place in a machine. Copies agree with each other better than
any measurement does, and their mean is no better than one of them.
"""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from einschalt.foundations.frame_columns import (
    columns_of,
    values_of,
    with_columns,
)

# points that a pair must have in common, and the share of them that must be equal
FEWEST_POINTS = 3
LEAST_SHARE = 0.5
OWNER = ["flight", "coverage", "model_id"]
# odd, their bits without pattern: what they make of two numbers tells pairs apart
MULTIPLIERS = (np.uint64(0x9E3779B97F4A7C15), np.uint64(0xC2B2AE3D27D4EB4F))
SHIFT = np.uint64(32)


@dataclass(frozen=True)
class CopiedModels:
    """A model, or a photograph, and its copy."""

    first: tuple[str, str, str]  # flight, coverage, model or image
    second: tuple[str, str, str]
    n_equal: int  # points with the same coordinates
    n_common: int


@dataclass(frozen=True)
class Copies:
    """What was given twice."""

    pairs: tuple[CopiedModels, ...]
    # by how much the errors of means are larger than claimed; 1 without copies. A mean
    # of n values of which m are copies has the error of n − m values
    enlargement: float


NO_COPIES = Copies((), 1.0)


def find_copies(examined) -> Copies:
    """Look for models or photographs whose coordinates are equal to the last digit."""
    flights = examined.block.flights
    if not may_repeat(values_of(_points_of(f), ["x", "y"]) for f in flights.values()):
        return NO_COPIES
    parts = [_rows_of(name, flight) for name, flight in flights.items()]
    rows = pd.concat(parts, ignore_index=True)
    keys = ["point_id", "x", "y"]
    is_twice = rows.duplicated(keys, keep=False).to_numpy()
    if not is_twice.any():
        return NO_COPIES
    owner = rows.groupby(OWNER, sort=False).ngroup().to_numpy()
    equal = _pairs(rows[is_twice].assign(owner=owner[is_twice]), keys)
    if equal.empty:
        return NO_COPIES
    names = rows[OWNER].drop_duplicates().to_numpy(dtype=object)
    held = rows.assign(owner=owner)
    n_common = _n_common(held, equal)
    is_copy = (equal["n"].to_numpy() >= FEWEST_POINTS) & (
        equal["n"].to_numpy() >= LEAST_SHARE * n_common
    )
    found = [
        CopiedModels(tuple(names[a]), tuple(names[b]), int(n), int(common))
        for (a, b, n), common in zip(
            equal[is_copy].itertuples(index=False), n_common[is_copy], strict=True
        )
    ]
    copies = set(equal.loc[is_copy, ["owner", "owner_other"]].to_numpy().ravel())
    is_again = held["owner"].isin(copies) & held.duplicated(["flight", *keys])
    share = is_again.groupby(held["flight"]).mean().max()
    return Copies(tuple(found), float(1.0 / np.sqrt(1.0 - share)))


def _points_of(flight):
    return flight.image_points if flight.has_images else flight.model_points


def may_repeat(coordinates):
    """Whether two points of any flight could have the same coordinates.

    False is certain: numbers made of the two coordinates, which are equal where these
    are, are sorted in a small part of the time that rows with names take.
    """
    xy = np.concatenate([each + 0.0 for each in coordinates])  # −0 is 0
    if np.isnan(xy).any():
        return True
    x, y = (np.ascontiguousarray(axis).view(np.uint64) for axis in xy.T)
    mixed = np.sort((x ^ (x >> SHIFT)) * MULTIPLIERS[0] ^ y * MULTIPLIERS[1])
    return bool((mixed[1:] == mixed[:-1]).any())


def _rows_of(name, flight):
    """Every measured point of a flight, with what it was measured in."""
    points = _points_of(flight)
    if flight.has_images:
        points = points.rename(columns={"image_id": "model_id"}).assign(coverage="")
    columns = columns_of(points, ["coverage", "model_id", "point_id", "x", "y"])
    return with_columns(columns, flight=name)


def _pairs(rows, keys):
    """Pairs of owners, and how many equal rows they have: owner, owner_other, n."""
    both = rows[[*keys, "owner"]].merge(
        rows[[*keys, "owner"]], on=keys, suffixes=("", "_other")
    )
    both = both[both["owner"] < both["owner_other"]]
    return both.groupby(["owner", "owner_other"]).size().rename("n").reset_index()


def _n_common(rows, pairs):
    """Points that both of each pair hold, whatever their coordinates, (n_pairs,)."""
    pair = pairs[["owner", "owner_other"]].assign(pair=np.arange(len(pairs)))
    held = rows[rows["owner"].isin(pair[["owner", "owner_other"]].to_numpy().ravel())]
    held = held[["owner", "point_id"]].drop_duplicates()
    of_other = held.rename(columns={"owner": "owner_other"})
    both = pair.merge(held).merge(of_other)
    return np.bincount(both["pair"], minlength=len(pairs))
