"""What ``einschalt serve`` does."""

from importlib.util import find_spec

from einschalt.foundations.errors import FileError, SettingsError
from einschalt.interfaces.cli.exits import print_out

LIBRARIES = ("starlette", "uvicorn")


def serve(folder, *, port=0, host="127.0.0.1", browser=True, most_upload=1000.0):
    """Serve the page until it is interrupted."""
    if not all(map(find_spec, LIBRARIES)):
        raise SettingsError(
            "einschalt serve needs starlette and uvicorn, which are not installed",
            expected="the extra 'serve' of einschalt",
            remedy="pip install '.[serve]' in the folder of the project",
        )
    if not folder.is_dir():
        raise FileError(
            "is no folder" if folder.exists() else "there is no such folder",
            expected="a folder in which blocks lie",
            remedy="Correct the path",
            file=folder,
        )
    # with the extra alone
    from einschalt.interfaces.local_page import server  # noqa: PLC0415

    options = {"host": host, "port": port, "opens": browser}
    server.serve(folder, print_out, **options, most_upload_mb=most_upload)
