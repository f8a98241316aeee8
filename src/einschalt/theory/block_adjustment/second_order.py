"""What a linear step of spatial models neglects where residuals are large.

A point of a model is T = t + λ a, turned by ω: its second derivatives by the turn are
(e_j a_k + e_k a_j) / 2 − δ_jk a, those by scale and turn e_j × a. Times w v and summed
over a model they are what Newton's method adds to the normal equations of
Gauss and Newton. Residuals of centimetres on arms of a kilometre make 1e-5 of them;
those of exchanged names make more than all of them, and linear steps go too far, each
farther than the one before.
"""

import numpy as np

N_BEFORE = 3  # shifts stand before scale and turn
AXES = range(1, 4)


def second_derivatives(incidence, arm, pulled, extent, *, is_positive):
    """Second-order part of the normal equations, (n_models, 4, 4): scale, then turn.

    ``arm`` (n_rows, 3) from the centre of the model, ``pulled`` (n_rows, 3) weighted
    residuals, ``extent`` (n_models,) the unit of arms. With ``is_positive`` without
    what makes them smaller, so that they stay positive definite anywhere.
    """
    model, n_models = incidence.model, incidence.n_models
    products = (pulled[:, :, None] * arm[:, None, :]).reshape(len(arm), -1)
    sums = [np.bincount(model, column, n_models) for column in products.T]
    sums = np.stack(sums, axis=1).reshape(n_models, 3, 3) / extent[:, None, None] ** 2
    second = np.zeros((n_models, 4, 4))
    second[:, 1:, 1:] = (sums + np.swapaxes(sums, 1, 2)) / 2.0
    second[:, AXES, AXES] -= np.trace(sums, axis1=1, axis2=2)[:, None]
    odd = sums - np.swapaxes(sums, 1, 2)
    turned = np.stack([odd[:, 2, 1], odd[:, 0, 2], odd[:, 1, 0]], axis=1)
    second[:, 0, 1:] = second[:, 1:, 0] = turned
    # of a model that ran away, which its sum of squares tells
    second[~np.isfinite(second).all(axis=(1, 2))] = 0.0
    if not is_positive:
        return second
    value, vector = np.linalg.eigh(second)
    kept = vector * np.maximum(value, 0.0)[:, None, :]
    return kept @ np.swapaxes(vector, 1, 2)


def among_unknowns(second, n_unknowns):
    """The same among all unknowns of each model, (n_models, n_unknowns, n_unknowns)."""
    places = slice(N_BEFORE, N_BEFORE + second.shape[1])
    whole = np.zeros((len(second), n_unknowns, n_unknowns))
    whole[:, places, places] = second
    return whole
