"""What the local page refuses, each with the status of its answer."""

from einschalt.foundations.errors import EinschaltError


class RefusedError(EinschaltError):
    """A request that is not served."""

    status = 400


class OutsideError(RefusedError):
    """A path that leads out of the folder that was given at the start."""

    status = 403


class MissingError(RefusedError):
    """Nothing of that name is there."""

    status = 404


class BusyError(RefusedError):
    """As much runs as may."""

    status = 429


class TooLargeError(RefusedError):
    """More bytes than are taken."""

    status = 413


class UnstoredError(RefusedError):
    """A file that the system does not store."""

    status = 507
