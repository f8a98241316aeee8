"""Compile the kernels, side by side: ``python -m tests.compile_kernels``.

A process that finds no compiled code compiles it, a minute long, and each worker of a
batch and each process that runs tests would do it for itself. ``make test`` does it
before, on two cores. What both parts need is compiled by the second one, while the
first one has kernels of its own to compile: it finds the others when it comes to them.
"""

import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import einschalt as es
from einschalt.foundations.batches import n_cores
from einschalt.stages.stage2_relative_orientation import relative_orientation
from einschalt.theory.block_adjustment import solver


def orientations():
    """Relative orientation; then models of images, and conformal ones."""
    blocks = [_block("images"), _block("parallaxes")]
    for outliers in ("huber", "snoop"):
        for block in blocks:
            relative_orientation(block.low_flight, outliers=outliers)
    for block in blocks:
        es.densify(block, es.Settings(outliers="snoop"))
    es.densify(blocks[0], es.Settings(outliers="huber"))
    # easting and northing as one complex number
    es.densify(_block("machine", "helmert"), es.Settings(**SIMULTANEOUS))


def plane():
    """Models in the plane: tests, weights by residuals, and adjustment of the block."""
    for settings in ({"outliers": "huber"}, {"outliers": "snoop"}, SIMULTANEOUS):
        es.densify(_block("machine"), es.Settings(**settings))
    es.densify(_block("machine"), es.Settings(residual_distribution=SIBSON))


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
        # by fronts, of which blocks as small as these need none
        solver.MOST_AT_ONCE = 0
        PARTS[sys.argv[1]]()
    else:
        with ThreadPoolExecutor(n_cores()) as pool:
            list(pool.map(compile_in_a_process, PARTS))
