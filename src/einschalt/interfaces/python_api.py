"""The Python interface: blocks and results that can also be written.

The lower floors compute and touch no files; here their objects learn to write
themselves.
"""

from dataclasses import dataclass

from einschalt.foundations.errors import SettingsError
from einschalt.interfaces.files.block_folder import read_block as read_checked_block
from einschalt.interfaces.files.block_folder import write_block
from einschalt.interfaces.files.result_folder import write_result
from einschalt.pipeline import block as checked
from einschalt.pipeline import densify as computed
from einschalt.pipeline import simulation as simulated
from einschalt.pipeline.settings import Settings


@dataclass(frozen=True, eq=False, kw_only=True)
class Block(checked.Block):
    """The checked tables of one survey, which can be written as a folder.

    Its fields are those of :class:`einschalt.pipeline.block.Block`:
    ``control_points``, ``high_flight`` or ``approximate_points``, ``low_flight``,
    ``crs``, ``name``, ``settings``.
    """

    def write(self, folder):
        """Write the block as a folder that :func:`read_block` reads.

        Parameters
        ----------
        folder : str or Path
            Made where it does not exist.
        """
        write_block(self, folder)


@dataclass(frozen=True, eq=False, kw_only=True)
class SimulatedBlock(simulated.SimulatedBlock, Block):
    """A block with known ``truth``, which can be written as a folder."""


@dataclass(frozen=True, eq=False, repr=False)
class DensificationResult(computed.DensificationResult):
    """Densified coordinates of a block, which can be written as a folder.

    Its tables are those of :class:`einschalt.pipeline.densify.DensificationResult`:
    ``points``, ``models``, ``residuals``, ``orientations``, ``failures``.
    """

    def write(self, folder):
        """Write tables, GeoPackage, report, summary and provenance into a folder.

        Every file is written whole or not at all; provenance.json comes last.

        Parameters
        ----------
        folder : str or Path
            Made where it does not exist.
        """
        write_result(self, folder)


def read_block(path):
    """Read a block from its folder and check it.

    Parameters
    ----------
    path : str or Path
        The folder, or its block.toml.

    Returns
    -------
    Block

    Raises
    ------
    EinschaltError
        Something in the input stops the computation; several faults come together.
    """
    return read_checked_block(path, kind=Block)


def densify(block, settings=None, *, progress=None):
    """Compute the coordinates of a block's points, with their precision.

    Parameters
    ----------
    block : Block
    settings : Settings, optional
        The block's own where left out.
    progress : callable, optional
        Called with the title of each stage and the fraction that is done.

    Returns
    -------
    DensificationResult
        A model that fails is a row of ``failures`` and does not stop the rest.

    Raises
    ------
    GeometryError
        Not one model of a flight could be used.

    See Also
    --------
    einschalt.pipeline.densify.densify : the five calls behind it.
    """
    if not isinstance(block, checked.Block):
        raise SettingsError(
            f"densify was given a {type(block).__name__}",
            expected="a Block",
            remedy="Read it with read_block, or make it with Block",
        )
    if not isinstance(settings, Settings | None):
        raise SettingsError(
            f"settings is a {type(settings).__name__}",
            expected="Settings",
            remedy="Write Settings(coverage_mean=…)",
        )
    result = computed.densify(block, settings, progress=progress)
    return DensificationResult(**checked.plain_fields(result))


def simulate_block(preset="neukirchen", *, seed=0, geometry=None, noise=None):
    """Simulate a block whose truth is known.

    Parameters
    ----------
    preset : str
        Name of a layout; ``neukirchen`` is the block of Kovarik 1971.
    seed : int
        The same seed gives the same block.
    geometry : BlockGeometry, optional
        Instead of the preset's.
    noise : BlockNoise, optional
        Instead of the preset's.

    Returns
    -------
    SimulatedBlock
        With ``truth``: point_id, easting, northing [, height].
    """
    block = simulated.simulate_block(preset, seed=seed, geometry=geometry, noise=noise)
    return SimulatedBlock(**checked.plain_fields(block))
