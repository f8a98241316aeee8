"""Models that are transformed again with every pair of some points exchanged."""

from dataclasses import dataclass

import numpy as np

from einschalt.foundations.batches import segments
from einschalt.foundations.frame_columns import columns_of, with_columns
from einschalt.foundations.names import CodedPairs, encode_pairs, is_among
from einschalt.stages.stage3_model_transformation import transform_models

PAIR = 2
MOST_ROWS = 1_000_000  # of the trials that are transformed together
MOST_SEARCHED = 3  # models of a flight, for more than a pair


@dataclass(frozen=True, eq=False)
class Trials:
    """Pairs of points whose names are exchanged, each in its model."""

    models: CodedPairs  # coverage and model_id of the models
    model: np.ndarray  # (n_trials,): place of its model
    pairs: np.ndarray  # (n_trials, 2): names of the two points

    @classmethod
    def of(cls, worst):
        """All pairs of the worst points of each model."""
        models = encode_pairs(worst["coverage"], worst["model_id"])
        points, model = worst["point_id"].to_numpy(dtype=object), models.codes
        _, rank = np.unique(points.astype(str), return_inverse=True)
        is_pair = (model[:, None] == model) & (rank[:, None] < rank)
        one, other = np.nonzero(is_pair)
        pairs = np.column_stack([points[one], points[other]])
        return cls(models, model[one], pairs)

    def m_0(self, measured, ground, kind):
        """m_0 of each trial's model, as it was measured and with exchanged names [m].

        NaN without redundancy. Each model is transformed once as it was measured.
        """
        models = encode_pairs(measured["coverage"], measured["model_id"])
        names = measured["point_id"]
        # others change no fit
        is_used = is_among(names, ground["point_id"]) | is_among(names, self.pairs.T[0])
        is_used |= is_among(names, self.pairs.T[1])
        parts = segments(models.codes[is_used], len(models))
        axes = [axis for axis in "xyz" if axis in measured]
        points = columns_of(measured, ["point_id", *axes])[is_used]
        own = np.arange(len(self.models))
        model = models.locate(self.models)[np.concatenate([own, self.model])]
        pairs = np.concatenate([np.full((len(own), PAIR), None), self.pairs])
        n_before = np.cumsum(parts.count[model]) // MOST_ROWS
        chunks = np.split(np.arange(len(model)), np.flatnonzero(np.diff(n_before)) + 1)
        m_0 = np.concatenate(
            [
                _m_0(points, parts, (model[chunk], pairs[chunk]), ground, kind)
                for chunk in chunks
            ]
        )
        return m_0[own][self.model], m_0[len(own) :]

    def best(self, m_0):
        """Trial with the least m_0 of each model, in the order of the models' names."""
        coverage, name = self.models.first[self.model], self.models.second[self.model]
        order = np.lexsort([m_0, name.astype(str), coverage.astype(str)])
        order = order[np.isfinite(m_0[order])]  # no exchange leaves others redundancy
        _, first = np.unique(self.model[order], return_index=True)
        return order[np.sort(first)]

    def named(self, trial):
        """Coverage, model_id, the pair of a trial, and what each was measured as."""
        model, pair = self.model[trial], self.pairs[trial]
        return self.models.first[model], self.models.second[model], pair, pair[::-1]

    def models_without(self, found, m_0, limit):
        """Coverage, model_id and m_0 of models that fit badly, the worst first.

        Without those of trials that were ``found``; none where they are more than
        ``MOST_SEARCHED``, which wrong ground does, and not the names of one model.
        ``m_0`` of each trial's model as it was measured, ``limit`` what is not bad [m].
        """
        trial = np.unique(self.model, return_index=True)[1]
        trial = trial[~np.isin(self.model[trial], self.model[found])]
        trial = trial[m_0[trial] > limit]
        if len(trial) > MOST_SEARCHED:
            return []
        trial = trial[np.argsort(-m_0[trial], kind="stable")]
        return [(*self.named(k)[:2], m_0[k]) for k in trial]


def _variants(points, parts, model, pairs):
    """Points of a model for each trial, with the names of its pair exchanged.

    ``parts`` are the rows of each model; model_id is the number of the trial.
    """
    rows, start = parts.rows_of(model)
    trial = np.repeat(np.arange(len(model)), np.diff(start))
    variants = points.take(rows)
    names = variants["point_id"].to_numpy(dtype=object)
    one, other = pairs[trial].T
    exchanged = np.where(names == one, other, np.where(names == other, one, names))
    return with_columns(variants, model_id=trial.astype(str), point_id=exchanged)


def _m_0(points, parts, trials, ground, kind):
    """m_0 of each trial, (n_trials,) [m]; NaN of a model without points to fit."""
    m_0 = np.full(len(trials[0]), np.nan)
    variants = _variants(points, parts, *trials)
    if len(variants):
        models = transform_models(variants, ground, kind).models
        m_0[models["model_id"].astype(int)] = models["m_0"]
    return m_0
