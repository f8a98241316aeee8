"""Gross errors of a block, looked for once for all of its adjustments.

What is looked for does not depend on what is to become of them, nor on deformations of
models that the adjustment finds afterwards. So adjustments of the same tables share it.
"""

from einschalt.theory.block_adjustment.gross_errors import ContradictedModelError
from einschalt.theory.block_adjustment.spatial_solution import NoConvergenceError

# what ends a search; the adjustment then gives a model up and begins anew
ENDS = (NoConvergenceError, ContradictedModelError)


class Searches:
    """What adjustments of the same tables have found out, each in its turn.

    With ``are_kept`` false nothing is: every adjustment looks for itself, and no memory
    is held.
    """

    def __init__(self, *, are_kept=True):
        self._are_kept = are_kept
        self._weighed = {}  # by the models and options of a search: Weighed, or its end
        self._results = {}  # by Weighed: what follows from it, None until it is known

    def weighed(self, models, options, search):
        """What ``search()`` finds, looked for once with these models and options.

        ``models`` are the verdicts on all models of the tables; ``options`` those of
        an adjustment that deals with gross errors. Raises what ended the search.
        """
        if not self._are_kept:
            return search()
        key = (
            models.tobytes(),
            options.common,
            options.significance,
            options.variance_components,
        )
        if key not in self._weighed:
            try:
                self._weighed[key] = search()
                self._results[self._weighed[key]] = None
            except ENDS as error:
                self._weighed[key] = error
        found = self._weighed[key]
        if isinstance(found, ENDS):
            raise found.with_traceback(None)
        return found

    def followed(self, weighed, follow):
        """What ``follow()`` makes of ``weighed``, made once if that was found here."""
        if weighed not in self._results:
            return follow()
        if self._results[weighed] is None:
            self._results[weighed] = follow()
        return self._results[weighed]
