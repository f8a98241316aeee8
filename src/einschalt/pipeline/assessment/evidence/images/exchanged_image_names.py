"""Two points of a photograph that were measured under each other's name.

A relative orientation with such a pair does not come to rest, or fits a hundred times
worse than the others, and which of its residuals are large tells little. So each model
that fits badly is oriented once more for every pair of its points, exchanged in either
photograph. The orientation itself cannot tell which one: the neighbours do, which hold
one of the photographs as well.
"""

from dataclasses import dataclass
from itertools import combinations

import numpy as np
import pandas as pd

from einschalt.foundations import tables
from einschalt.foundations.errors import name_some
from einschalt.foundations.frame_columns import MODEL, values_of
from einschalt.pipeline.densification.result_tables import of_orientations
from einschalt.stages.stage2_relative_orientation import image_pairs

SIDES = {"left_image": ["x_left", "y_left"], "right_image": ["x_right", "y_right"]}
COORDINATES = [*SIDES["left_image"], *SIDES["right_image"]]
# of the median sigma_0 of the flight: what is bad, and what mended models come to
LARGE_SIGMA = 3.0
# and by how much it must improve, so that no chance improvement counts
LEAST_IMPROVEMENT = 5.0
FEWEST_POINTS = 8  # with fewer than three redundant ones some exchange fits by chance
MOST_MODELS = 20
# all pairs of so many points are tried (990); of more those of the worst
MOST_POINTS, MOST_SUSPECTS = 45, 12


@dataclass(frozen=True)
class ExchangedImageNames:
    """A pair of points that were measured under each other's name in a photograph."""

    flight: str
    points: tuple[str, str]
    # the photograph; two where the models that hold them do not tell which
    images: tuple[str, ...]
    # coverage and model_id of the models that hold a point of the pair in one of these
    models: tuple[tuple[str, str], ...]
    # of the model that it spoils most, as measured and with the names put right [mm];
    # infinite where it could not be oriented
    sigma_0: float
    sigma_0_exchanged: float
    takes_part: bool  # not where data snooping has taken the points out


def find_exchanged_image_names(examined) -> tuple[ExchangedImageNames, ...]:
    """Look for exchanged names in all pairs of photographs that fit badly."""
    found = {}
    for name, flight in examined.block.flights.items():
        if not flight.has_images:
            continue
        for exchange in _in_flight(examined, name, flight):
            found.setdefault(
                (name, frozenset(exchange.points), exchange.images), exchange
            )
    return tuple(sorted(found.values(), key=lambda each: -each.sigma_0))


@dataclass(frozen=True, eq=False)
class _Oriented:
    """A block whose flights were oriented, and nothing more."""

    block: object
    orientations: pd.DataFrame
    orientation_residuals: pd.DataFrame


def with_exchanged_names(error, block, flights):
    """The same error, naming exchanged image points as its cause where there are any.

    ``flights`` are the orientations of each flight.
    """
    tables = of_orientations(flights)
    del tables["orientation_errors"]
    found = find_exchanged_image_names(_Oriented(block, **tables))
    if not found:
        return error
    pairs = name_some(
        f"{', '.join(each.points)} ({' / '.join(each.images)})" for each in found
    )
    return error.with_facts(
        remedy="Put right the names of points that are exchanged in photographs: "
        f"{pairs}"
    )


def _in_flight(examined, name, flight):
    measured = _Photographs(flight)
    usual = _usual_sigma_0(examined, name)
    residuals = examined.orientation_residuals
    residuals = residuals[residuals["flight"] == name]
    oriented = examined.orientations[examined.orientations["flight"] == name]
    for key, is_bad in _candidates(oriented, residuals, measured, usual):
        rows = measured.pairs_of(key)
        tried = _tried(rows, residuals, key, is_bad=is_bad)
        if len(rows) < FEWEST_POINTS or len(tried) < len(("one", "other")):
            continue
        before = measured.sigma_0([rows])[0]
        pair, after = _best_exchange(measured, rows, tried)
        if not after <= min(LARGE_SIGMA * usual, before / LEAST_IMPROVEMENT):
            continue
        images = measured.mended_in(key, pair, LARGE_SIGMA * usual)
        if not images:
            continue
        models = measured.models_that_hold(images, pair)
        yield ExchangedImageNames(
            flight=name,
            points=pair,
            images=images,
            models=models,
            sigma_0=float(before),
            sigma_0_exchanged=float(after),
            takes_part=not set(models) <= set(_good_models(oriented, usual)),
        )


def _usual_sigma_0(examined, name):
    rows = examined.orientations
    return float(rows.loc[rows["flight"] == name, "sigma_0"].astype(float).median())


def _good_models(oriented, usual):
    is_good = oriented["is_converged"].astype(bool) & (
        oriented["sigma_0"].astype(float) <= LARGE_SIGMA * usual
    )
    return _keys(oriented[is_good])


def _candidates(oriented, residuals, measured, usual):
    """Keys of models that fit badly, with True, and of those with several suspects."""
    sigma = oriented["sigma_0"].astype(float)
    good = set(_good_models(oriented, usual))
    worst_first = _keys(oriented.loc[sigma.sort_values(ascending=False).index])
    known = set(worst_first)
    lost = [key for key in _keys(measured.models) if key not in known]
    bad = lost + [key for key in worst_first if key not in good]
    found = [(key, True) for key in bad[:MOST_MODELS]]
    if "is_suspect" in residuals:
        n_wrong = (
            residuals["is_suspect"]
            .astype(int)
            .groupby([residuals[name].astype(str) for name in MODEL])
        )
        several = n_wrong.sum().sort_values(ascending=False, kind="stable")
        several = several[several > 1].index
        found += [(key, False) for key in several[:MOST_MODELS] if key in good]
    return found


def _tried(rows, residuals, key, *, is_bad):
    """Names of the points of a model among which the pair is looked for.

    The suspects where it fits without them; all, or the worst of many, where it fits
    badly: its residuals then tell little.
    """
    if is_bad and len(rows) <= MOST_POINTS:
        return rows["point_id"].to_numpy(dtype=object)
    own = residuals[_is_of(residuals, key)]
    if "p_value" not in own:
        return rows["point_id"].to_numpy(dtype=object)[:0]
    own = own if is_bad else own[own["is_suspect"].astype(bool)]
    worst = own.sort_values("p_value", kind="stable")["point_id"].head(MOST_SUSPECTS)
    return worst.to_numpy(dtype=object)


def _best_exchange(measured, rows, tried):
    """The pair whose exchange makes a model fit best, and its sigma_0 then [mm]."""
    places = np.flatnonzero(rows["point_id"].isin(tried).to_numpy())
    pairs = np.array(list(combinations(places, 2)))
    coordinates = np.repeat(values_of(rows, COORDINATES)[None], len(pairs), axis=0)
    trial, left = np.arange(len(pairs))[:, None], np.arange(2)
    for one, other in (pairs.T, pairs.T[::-1]):
        coordinates[trial, one[:, None], left] = values_of(rows, COORDINATES)[other, :2]
    names = rows["point_id"].to_numpy(dtype=object)
    variants = pd.DataFrame(coordinates.reshape(-1, 4), columns=COORDINATES)
    variants["point_id"] = np.tile(names, len(pairs))
    variants["model_id"] = np.repeat(trial.ravel().astype(str), len(names))
    sigma = measured.sigma_0_of(variants, len(pairs))
    best = int(np.argmin(sigma))
    return tuple(map(str, names[pairs[best]])), float(sigma[best])


class _Photographs:
    """The photographs of a flight, and the models that they make."""

    def __init__(self, flight):
        self.flight = flight
        self.models = tables.with_coverage(flight.models)
        self.points = flight.image_coordinates()

    def pairs_of(self, key, points=None):
        """Image coordinates of a model: point_id and COORDINATES [mm]."""
        points = self.points if points is None else points
        is_it = _is_of(self.models, key)
        return image_pairs(points, self.models[is_it]).reset_index(drop=True)

    def sigma_0(self, parts):
        """sigma_0 of models, each by itself [mm]; infinite without orientation."""
        named = [part.assign(model_id=str(k)) for k, part in enumerate(parts)]
        return self.sigma_0_of(pd.concat(named, ignore_index=True), len(named))

    def sigma_0_of(self, variants, n_models):
        """The same of one table, whose model_id counts from 0."""
        # imported where photographs are oriented: other blocks do not wait for it
        from einschalt.stages.relative_orientation.orient_from_images import (  # noqa: PLC0415
            orient_from_images,
        )

        case = self.flight.orientation_case
        oriented = orient_from_images(
            variants[["model_id", "point_id", *COORDINATES]],
            self.flight.principal_distance_mm,
            **({} if case is None else {"case": case}),
        )
        models = oriented.models.set_index("model_id")
        sigma = models["sigma_0"].where(models["is_converged"].astype(bool))
        sigma = sigma.reindex(np.arange(n_models).astype(str))
        return sigma.fillna(np.inf).to_numpy(dtype=float)

    def models_that_hold(self, images, pair):
        """Keys of the models of photographs in which a point of a pair is measured."""
        is_own = self.models[list(SIDES)].isin(images).any(axis=1)
        held = image_pairs(self.points, self.models[is_own])
        held = held[held["point_id"].isin(pair)]
        return tuple(dict.fromkeys(_keys(held)))

    def mended_in(self, key, pair, limit):
        """Photographs of a model in which the exchange mends all models of both."""
        is_it = _is_of(self.models, key)
        images = tuple(self.models.loc[is_it, list(SIDES)].iloc[0])
        neighbours = self.models_that_hold(images, pair)
        mended = []
        for image in images:
            points = self._exchanged(image, pair)
            parts = (self.pairs_of(one, points) for one in neighbours)
            parts = [part for part in parts if len(part)]
            if (self.sigma_0(parts) <= limit).all():
                mended.append(str(image))
        return tuple(mended)

    def _exchanged(self, image, pair):
        """Image points with a pair of names exchanged in one photograph."""
        one, other = pair
        names = self.points["point_id"]
        is_its = (self.points["image_id"] == image) & names.isin(pair)
        exchanged = names.where(~is_its, names.map({one: other, other: one}))
        return self.points.assign(point_id=exchanged)


def _is_of(rows, key):
    """Which rows are of the model with a key."""
    of_each = (
        rows[name].astype(str) == part for name, part in zip(MODEL, key, strict=True)
    )
    return np.logical_and.reduce(list(of_each))


def _keys(rows):
    return list(rows[MODEL].astype(str).itertuples(index=False, name=None))
