"""What tells a displaced region from larger errors, and from a smooth pattern.

By the scores of the points in it and around it; see displaced_regions for these.
"""

import numpy as np

from einschalt.theory.adjustment.smooth_pattern import smooth_pattern

MOST_AROUND = 250  # points in and around a region that are looked at together
LEAST_RANK = 1e-6  # of what is known of points


class Around:
    """Points in and around a region, thinned where they are many."""

    def __init__(self, scan, region):
        middle = scan.xy[region.rows].mean(axis=0)
        apart = np.sum((scan.xy - middle) ** 2, axis=1)
        n_near = max(3 * len(region.rows), MOST_AROUND)
        near = np.argsort(apart, kind="stable")[:n_near]
        rows = np.sort(near[:: -(-len(near) // MOST_AROUND)])
        self.information, self.scores = scan.block(rows), scan.scores[rows]
        self.xy, self.region, self.n_tried = scan.xy[rows], region, scan.n_tried
        self.is_scaled = scan.is_scaled

    def smoothness(self):
        """Probability that chance makes a smooth pattern as clear as this one."""
        both = np.column_stack([self.scores.real, self.scores.imag])
        found = smooth_pattern(both, np.real(self.information), self.xy)
        return found.p_value_if_scaled if self.is_scaled else found.p_value

    def tail(self):
        """Probability of the region by the scatter of the scores without it.

        F with the degrees of freedom of the points around, of all regions together.
        """
        own = (self.information + self.information.conj().T) / 2.0
        values, vectors = np.linalg.eigh(own)
        is_known = values > LEAST_RANK * max(values.max(), 0.0)
        white = vectors[:, is_known].conj().T @ self.scores
        rest = np.sum(np.abs(white) ** 2 / values[is_known])
        # what single points were chosen by is scatter as well
        rest += self.region.square - self.region.certain
        if not rest > 0.0:
            return 0.0
        degrees = np.count_nonzero(is_known)  # of each coordinate
        return float(self.n_tried * (1.0 + self.region.certain / rest) ** -degrees)
