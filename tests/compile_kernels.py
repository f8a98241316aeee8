"""Compile the kernels, side by side: ``python -m tests.compile_kernels``.

A process that finds no compiled code compiles it, a minute long, and each worker of a
batch and each process that runs tests would do it for itself. ``make test`` does it
before, on two cores: each part uses kernels that the others do not.
"""

import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import einschalt as es
from einschalt.foundations.batches import n_cores


def orientations():
    """Relative orientation, and models in space."""
    for measurement in ("images", "parallaxes"):
        es.densify(_block(measurement), es.Settings(outliers="snoop"))
    es.densify(_block("images"), es.Settings(outliers="huber"))


def plane():
    """Models in the plane: tests, weights by residuals, and adjustment of the block."""
    for settings in ({"outliers": "huber"}, {"outliers": "snoop"}, SIMULTANEOUS):
        es.densify(_block("machine"), es.Settings(**settings))
    es.densify(_block("machine"), es.Settings(residual_distribution=SIBSON))
    # easting and northing as one complex number
    es.densify(_block("machine", "helmert"), es.Settings(**SIMULTANEOUS))


def _block(measurement, kind="affine"):
    geometry = es.BlockGeometry(
        width=3e3, height=3e3, measurement=measurement, transformation=kind
    )
    return es.simulate_block("demo", seed=1, geometry=geometry)


SIMULTANEOUS = {"method": "simultaneous"}
SIBSON = "natural_neighbour"
PARTS = {part.__name__: part for part in (orientations, plane)}


def compile_in_a_process(part):
    subprocess.run([sys.executable, "-m", "tests.compile_kernels", part], check=True)


if __name__ == "__main__":
    if len(sys.argv) > 1:
        PARTS[sys.argv[1]]()
    else:
        with ThreadPoolExecutor(n_cores()) as pool:
            list(pool.map(compile_in_a_process, PARTS))
