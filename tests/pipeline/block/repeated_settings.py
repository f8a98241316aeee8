"""Blocks whose points were set several times, for tests of two rooms."""

from dataclasses import fields, replace

import numpy as np

import einschalt as es
from einschalt.pipeline.simulation.simulate_block import PRESETS, simulate_block

M_G_UM = 5.0
KEY = ["coverage", "model_id", "point_id"]


def true_block(seed):
    """A demo block whose low flight was measured without errors."""
    noise = replace(PRESETS["demo"].noise, low_m_g_um=0.0)
    return simulate_block("demo", seed=seed, noise=noise)


def rows_of_settings(seed=0, *, n_settings=3, scale=1.0):
    """Model points set several times with known errors, a row for each setting."""
    true = true_block(seed).low_flight.model_points
    rows = true.loc[true.index.repeat(n_settings)].reset_index(drop=True)
    sigma_mm = M_G_UM * 1e-3 / np.sqrt(2.0)
    error = np.random.default_rng(seed).normal(0.0, sigma_mm, (len(rows), 2))
    rows[["x", "y"]] = scale * (rows[["x", "y"]] + error)
    number = np.tile(np.arange(1, n_settings + 1), len(true))
    return rows.assign(setting=number.astype(str))


def set_again(seed=0, *, m_g_um=M_G_UM, scale=1.0, **facts):
    """A block of them; ``facts`` are those of the flight."""
    block, rows = true_block(seed), rows_of_settings(seed, scale=scale)
    facts = {"model_points": rows, "m_g_um": m_g_um, **facts}
    return with_low_flight(block, replace(block.low_flight, **facts))


def with_low_flight(block, low):
    plain = {f.name: getattr(block, f.name) for f in fields(es.Block)}
    return es.Block(**{**plain, "low_flight": low})
