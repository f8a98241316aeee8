"""What ``einschalt publish`` does."""

from einschalt.interfaces.cli.exits import print_out
from einschalt.interfaces.cli.outcome import report, report_problems
from einschalt.interfaces.publication.publish import require_name
from einschalt.interfaces.publication.published_results import publish as publish_result


def publish(result, name, output, crs, source_crs, installed_at, proj_db, *, overwrite):
    """Publish the result in a folder, and say how it is found."""
    require_name(name)
    published = publish_result(
        result,
        name,
        output or result / name,
        crs=crs,
        source_crs=source_crs,
        installed_at=installed_at,
        proj_db=proj_db,
        overwrite=overwrite,
    )
    report(published.folder, n_operations=len(published.operations))
    report_problems(*published.doubts)
    print_out(published)
