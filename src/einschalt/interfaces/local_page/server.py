"""The server of the local page: on loopback alone, until it is ended."""

import contextlib
import errno
import os
import socket
import webbrowser
from html import escape

import uvicorn
from starlette.applications import Starlette
from starlette.responses import HTMLResponse, PlainTextResponse, Response
from starlette.routing import Route

from einschalt.foundations.errors import SettingsError
from einschalt.foundations.language import language, translated
from einschalt.foundations.system_errors import reason_of
from einschalt.interfaces.local_page import (
    batch_pages,
    block_pages,
    compare_pages,
    drop_pages,
    plan_pages,
    words,
)
from einschalt.interfaces.local_page.door import KEY, LOOPBACK, Door
from einschalt.interfaces.local_page.pages import refused, static_text
from einschalt.interfaces.local_page.session import Session

KINDS = {"css": "text/css", "js": "text/javascript", "svg": "image/svg+xml"}
LEAD_ON = """<!DOCTYPE html><html lang="{language}"><title>einschalt</title>
<link rel="icon" href="/static/icon.svg">
<meta http-equiv="refresh" content="0; url={address}">
<a href="{address}">einschalt serve</a></html>
"""


async def home(request):
    """Take the key out of the address into a cookie, or show the folder."""
    door = request.app.state.door
    if KEY not in request.query_params:
        return await block_pages.folder_page(request)
    # not by a redirect: a browser that came from a file would leave the cookie out
    answer = HTMLResponse(LEAD_ON.format(address="/", language=language()))
    options = {"httponly": True, "samesite": "strict", "path": "/"}
    answer.set_cookie(door.cookie, door.key, **options)
    return answer


async def static(request):
    """A script or style of the page."""
    name = request.path_params["name"]
    text = static_text(name)
    if text is None:
        return PlainTextResponse(translated(words.NOT_FOUND), 404)
    kind = KINDS.get(name.rpartition(".")[2], "text/plain")
    return Response(text, media_type=kind)


async def quit_page(request):
    """End the server after this answer."""
    request.app.state.end()
    return PlainTextResponse(f"{translated(words.ENDED_HERE)}\n")


async def _not_found(request, _error):
    return refused(request, [translated(words.NOT_FOUND)], 404)


async def _fault(request, _error):
    return refused(request, [translated(words.FAULT)], 500)


def _routes():
    number = "{number:int}"
    return [
        Route("/", home),
        Route("/static/{name}", static),
        Route("/block", block_pages.block_page),
        Route("/start", block_pages.start, methods=["POST"]),
        Route(f"/run/{number}", block_pages.run_page),
        Route(f"/run/{number}/state", block_pages.run_state),
        Route(f"/run/{number}/cancel", block_pages.cancel, methods=["POST"]),
        Route("/result", block_pages.result_page),
        Route("/report", block_pages.report),
        Route("/drop", drop_pages.new_drop, methods=["POST"]),
        Route(f"/drop/{number}", drop_pages.opened_drop),
        Route(f"/drop/{number}/{{name:path}}", drop_pages.take_file, methods=["PUT"]),
        Route("/new", drop_pages.new_page),
        Route("/new", drop_pages.make_block, methods=["POST"]),
        Route("/compare", compare_pages.compare_page),
        Route("/plan", plan_pages.plan_page),
        Route("/plan/figures", plan_pages.plan_figures),
        Route("/plan/map", plan_pages.plan_map),
        Route("/batch", batch_pages.batch_page),
        Route("/batch", batch_pages.start_batch, methods=["POST"]),
        Route("/quit", quit_page, methods=["POST"]),
    ]


def application(session, port, end=lambda: None):
    """The page of a session, as an ASGI application behind its door.

    ``end`` is called where the user ends the server from the page.
    """

    @contextlib.asynccontextmanager
    async def lifespan(_app):
        yield
        session.close()

    app = Starlette(
        routes=_routes(),
        lifespan=lifespan,
        exception_handlers={404: _not_found, 405: _not_found, 500: _fault},
    )
    door = Door(app, session.key, port)
    app.state.session, app.state.door, app.state.end = session, door, end
    return door


def serve(folder, say, *, host="127.0.0.1", port=0, opens=True, most_upload_mb):
    """Serve the page of a folder until it is interrupted, or ended from the page.

    ``host`` is one of the two names of this computer; port 0 is any that is free;
    ``say`` prints a line; ``opens`` shows the page in the user's browser.
    """
    if host not in LOOPBACK:
        raise ValueError(host)
    session = Session(folder, most_upload_mb=most_upload_mb)
    try:
        with _listening(host, port) as listener:
            number = listener.getsockname()[1]
            name = f"[{host}]" if ":" in host else host
            address = f"http://{name}:{number}/?{KEY}={session.key}"
            _run(session, listener, number, lambda: _tell(session, address, say, opens))
    finally:
        session.close()


def _run(session, listener, port, is_ready):
    server = None

    def end():
        server.should_exit = True

    config = uvicorn.Config(
        application(session, port, end),
        log_level="warning",
        access_log=False,
        server_header=False,
        timeout_keep_alive=5,
        timeout_graceful_shutdown=5,
        h11_max_incomplete_event_size=2**16,
        http="h11",
        ws="none",
        lifespan="on",
    )
    server = uvicorn.Server(config)
    is_ready()
    server.run(sockets=[listener])


def _listening(host, port):
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    listener = socket.socket(family, socket.SOCK_STREAM)
    try:
        if os.name == "posix":
            # connections of a server that has ended keep its port for a minute; on
            # Windows the option would share it with a server that runs
            listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listener.bind((host, port))
        # where two begin at once both are bound, and one of them may not listen
        listener.listen(128)
    except OSError as error:
        listener.close()
        if port == 0 or error.errno not in (errno.EADDRINUSE, errno.EACCES):
            raise
        raise SettingsError(
            f"--port = {port} on {host}: {reason_of(error)}",
            expected="a port that is free",
            remedy="Give another --port, or leave it out: any that is free is taken",
        ) from None
    return listener


def _tell(session, address, say, opens):
    say(words.SERVING.format(folder=session.root.path))
    say(translated(words.ADDRESS, address=address))
    say(translated(words.HOW_TO_END))
    if not opens:
        return
    # other users see what a browser is started with: the key stands in a file
    start = session.folder / "start.html"
    text = LEAD_ON.format(address=escape(address), language=language())
    start.write_text(text, encoding="utf-8")
    start.chmod(0o600)
    with contextlib.suppress(webbrowser.Error):  # none is there: the address is printed
        webbrowser.open(start.as_uri())
