"""What ``einschalt densify`` does."""

from einschalt.interfaces import python_api
from einschalt.interfaces.cli.exits import print_out
from einschalt.interfaces.cli.progress import stage_progress
from einschalt.interfaces.files.ellipse_layer import require_scale
from einschalt.interfaces.files.result_folder import refuse_block_folder
from einschalt.pipeline.progress import Stage


def densify_folder(block, output, given, *, ellipse_scale=None, is_quiet=False):
    """Compute a block, write its results and print their summary.

    Parameters
    ----------
    block, output : Path
    given : dict
        Settings that go before those of block.toml.
    ellipse_scale : float, optional
        How much larger the ellipses are drawn.
    is_quiet : bool
        Print nothing.

    Raises
    ------
    EinschaltError
        The input is wrong, or the results cannot be written.
    """
    # before the work, which would be lost
    refuse_block_folder(output)
    require_scale(ellipse_scale)
    read = python_api.read_block(block)
    settings = read.settings.updated(given)
    with stage_progress(is_quiet=is_quiet) as progress:
        result = python_api.densify(read, settings, progress=progress)
        progress(Stage.WRITING, Stage.WRITING.fraction)
        result.write(output, ellipse_scale=ellipse_scale)
    if not is_quiet:
        print_out(result.summary())
        print_out(f"Results in {output}, report in {output / 'report.html'}")
