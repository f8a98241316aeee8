"""Units at the edge: the only place with conversion factors.

Inside the package everything is metres and radians.
"""

import numpy as np

METRES_PER_UM = 1e-6
METRES_PER_MM = 1e-3
METRES_PER_UNIT = {"um": 1e-6, "mm": 1e-3, "cm": 1e-2, "m": 1.0}
RADIANS_PER_GON = np.pi / 200.0


def ground_from_image_um(length_um, scale_number):
    """Length on the ground of a length in the image.

    Parameters
    ----------
    length_um : float or ndarray
        Length in the image plane [µm].
    scale_number : float or ndarray
        Denominator of the image scale, 8000 for 1:8000.

    Returns
    -------
    float or ndarray
        Length on the ground [m].

    Examples
    --------
    >>> float(ground_from_image_um(5.0, 8000))
    0.04
    """
    return np.multiply(length_um, scale_number) * METRES_PER_UM
