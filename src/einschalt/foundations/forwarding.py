"""Classes that give what one of their parts has."""

from operator import attrgetter


def forwarding(part, *names):
    """Decorate a class: it gives what a part of it has under these names.

    >>> @forwarding("inner", "real")
    ... class Holder:
    ...     inner = 2.5
    >>> Holder().real
    2.5
    """

    def decorated(kind):
        for name in names:
            setattr(kind, name, property(attrgetter(f"{part}.{name}")))
        return kind

    return decorated
