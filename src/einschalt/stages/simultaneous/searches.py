"""Gross errors of a block, looked for once for all of its adjustments.

What is looked for does not depend on what is to become of them, nor on deformations of
models that the adjustment finds afterwards. So adjustments of the same tables share it.
"""

from collections.abc import Callable, Hashable
from dataclasses import dataclass
from typing import TypeVar

from einschalt.stages.simultaneous.variance_components import Weighed
from einschalt.theory.block_adjustment.gross_errors import ContradictedModelError
from einschalt.theory.block_adjustment.spatial_solution import NoConvergenceError

Result = TypeVar("Result")
# what ends a search; the adjustment then gives a model up and begins anew
ENDS = (NoConvergenceError, ContradictedModelError)


@dataclass(frozen=True)
class _End:
    """What a search has ended with, without the frames that it ended in."""

    kind: type[Exception]
    arguments: tuple
    facts: dict

    def raised_again(self) -> Exception:
        """The exception anew."""
        error = self.kind.__new__(self.kind, *self.arguments)
        error.args = self.arguments
        vars(error).update(self.facts)
        return error


class Searches:
    """What adjustments of the same tables have found out, each in its turn.

    With ``are_kept`` false nothing is: every adjustment looks for itself, and no memory
    is held. A copy, as of a result that is pickled, begins anew.
    """

    def __init__(self, *, are_kept: bool = True) -> None:
        self._are_kept = are_kept
        self._weighed = {}  # by the key of a search: Weighed, or its end
        self._results = {}  # by Weighed: what follows from it, None until it is known

    def __getstate__(self):
        """Whether searches are kept, and none of them."""
        return vars(Searches(are_kept=self._are_kept))

    def weighed(self, key: Hashable, search: Callable[[], Weighed]) -> Weighed:
        """What ``search()`` finds, looked for once with this key.

        The key has all that a search of these tables depends on. Raises what ended the
        search.
        """
        if not self._are_kept:
            return search()
        if key not in self._weighed:
            try:
                self._weighed[key] = search()
                self._results[self._weighed[key]] = None
            except ENDS as error:
                self._weighed[key] = _End(type(error), error.args, vars(error))
        found = self._weighed[key]
        if isinstance(found, _End):
            raise found.raised_again()
        return found

    def followed(self, weighed: Weighed, follow: Callable[[], Result]) -> Result:
        """What ``follow()`` makes of ``weighed``, made once if that was found here."""
        if weighed not in self._results:
            return follow()
        if self._results[weighed] is None:
            self._results[weighed] = follow()
        return self._results[weighed]
