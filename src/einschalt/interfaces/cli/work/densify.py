"""What ``einschalt densify`` does."""

from einschalt.interfaces import python_api
from einschalt.interfaces.cli.exits import print_out
from einschalt.interfaces.cli.progress import stage_progress
from einschalt.interfaces.files.ellipse_layer import require_scale
from einschalt.interfaces.files.output_folder import held_folder
from einschalt.interfaces.files.result_folder import output_of, write_result
from einschalt.pipeline.progress import Stage, stage_reporter


def densify_folder(
    block, output, given, *, ellipse_scale=None, overwrite=False, is_quiet=False
):
    """Compute a block, write its results and print their summary.

    Parameters
    ----------
    block, output : Path
    given : dict
        Settings that go before those of block.toml.
    ellipse_scale : float, optional
        How much larger the ellipses are drawn.
    overwrite : bool, optional
        Replace what lies in the folder of the results, inputs excepted.
    is_quiet : bool
        Print nothing.

    Raises
    ------
    EinschaltError
        The input is wrong, or the results cannot be written.
    """
    # before the work, which would be lost
    require_scale(ellipse_scale)
    read = python_api.read_block(block, given)
    settings = read.settings
    with (
        held_folder(output, output_of(read, overwrite=overwrite)),
        stage_progress(is_quiet=is_quiet) as progress,
    ):
        report_progress = stage_reporter(progress)
        result = python_api.densify(read, settings, progress=progress)
        report_progress(Stage.ASSESSMENT)
        result.assessment  # noqa: B018
        report_progress(Stage.WRITING)
        options = {"ellipse_scale": ellipse_scale, "overwrite": overwrite}
        write_result(result, output, **options, beside=True)
    if not is_quiet:
        print_out(result.summary())
        print_out(f"Results in {output}, report in {output / 'report.html'}")
