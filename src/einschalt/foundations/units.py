"""Units at the edge: the only place with conversion factors.

Inside the package everything is metres and radians.
"""

import numpy as np

METRES_PER_UM = 1e-6
METRES_PER_MM = 1e-3
MM_PER_UM, UM_PER_MM = 1e-3, 1e3
METRES_PER_UNIT = {"um": 1e-6, "mm": 1e-3, "cm": 1e-2, "m": 1.0}
METRES_PER_KM = 1000.0
RADIANS_PER_GON = np.pi / 200.0


def ground_from_image_um(length_um, scale_number):
    """Length on the ground [m] of a length in the image [µm].

    ``scale_number`` is the denominator of the image scale, 8000 for 1:8000.

    >>> float(ground_from_image_um(5.0, 8000))
    0.04
    """
    return np.multiply(length_um, scale_number) * METRES_PER_UM
