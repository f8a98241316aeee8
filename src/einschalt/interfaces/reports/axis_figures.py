"""Figures at the axes of diagrams, in the language of who looks at them."""

from matplotlib.ticker import ScalarFormatter

from einschalt.foundations.language import language, numbers_set, written_in


class AxisFigures(ScalarFormatter):
    """Figures at an axis, as the language has them in which it was made."""

    def __init__(self):
        super().__init__()
        self._language = language()

    def __call__(self, x, pos=None):
        """Figure at a tick; it is asked for when the figure is drawn."""
        with written_in(self._language):
            return numbers_set(super().__call__(x, pos))


def set_figures(axis):
    """Write the numbers of an axis in the active language; words of others stay."""
    if isinstance(axis.get_major_formatter(), ScalarFormatter):
        axis.set_major_formatter(AxisFigures())
