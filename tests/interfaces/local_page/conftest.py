"""The local page in this process: requests as browsers send them, and others."""

import asyncio
from types import SimpleNamespace
from urllib.parse import urlencode

import pytest

pytest.importorskip("starlette", reason="the extra serve is not installed")
pytest.importorskip("uvicorn", reason="the extra serve is not installed")

PORT = 8417
OWN = f"http://127.0.0.1:{PORT}"


class Visitor:
    """Sends requests to the application, with the headers of its own pages."""

    def __init__(self, session, app):
        self.session = session
        self.app = app
        self.n_sent = 0  # bytes of the last body that were asked for
        self.headers = {
            "host": f"127.0.0.1:{PORT}",
            "cookie": f"einschalt-{PORT}={session.key}",
        }

    def get(self, address, **headers):
        return asyncio.run(self.answer("GET", address, (), headers))

    def post(self, address, fields=(), **headers):
        body = urlencode(fields).encode()
        own = {"origin": OWN, "content-length": str(len(body))}
        return asyncio.run(self.answer("POST", address, (body,), own | headers))

    def put(self, address, chunks, **headers):
        own = {"origin": OWN}
        return asyncio.run(self.answer("PUT", address, chunks, own | headers))

    async def answer(self, method, address, chunks, headers):
        """Answer of the application; the body is made while it is read."""
        path, _, query = address.partition("?")
        given = {**self.headers, **{k.replace("_", "-"): v for k, v in headers.items()}}
        scope = {
            "type": "http",
            "http_version": "1.1",
            "method": method,
            "scheme": "http",
            "path": path,
            "raw_path": path.encode(),
            "query_string": query.encode(),
            "root_path": "",
            "server": ("127.0.0.1", PORT),
            "client": ("127.0.0.1", 50_000),
            "headers": [
                (name.encode(), value.encode())
                for name, value in given.items()
                if value is not None
            ],
        }
        waiting, sent = iter(chunks), []
        self.n_sent, is_ended = 0, asyncio.Event()

        async def receive():
            chunk = next(waiting, None)
            if chunk is not None:
                self.n_sent += len(chunk)
                return {"type": "http.request", "body": chunk, "more_body": True}
            if is_ended.is_set():
                await asyncio.Event().wait()  # the visitor stays until it is answered
            is_ended.set()
            return {"type": "http.request", "body": b"", "more_body": False}

        async def send(message):
            sent.append(message)

        await self.app(scope, receive, send)
        head = {k.decode(): v.decode() for k, v in sent[0]["headers"]}
        body = b"".join(message.get("body", b"") for message in sent[1:])
        text = body.decode("utf-8", errors="replace")
        return SimpleNamespace(status=sent[0]["status"], headers=head, text=text)


@pytest.fixture
def visit(tmp_path):
    """Make a visitor of a session whose root is a folder."""
    from einschalt.interfaces.local_page.server import application
    from einschalt.interfaces.local_page.session import Session

    sessions = []

    def make(folder, **options):
        session = Session(folder, **options)
        sessions.append(session)
        return Visitor(session, application(session, PORT))

    yield make
    for session in sessions:
        session.close()


@pytest.fixture
def root(tmp_path):
    """The folder that the page is given, with something secret beside it."""
    folder = tmp_path / "root"
    folder.mkdir()
    (tmp_path / "secret").mkdir()
    (tmp_path / "secret" / "control_points.csv").write_text("point_id\nhidden\n")
    return folder
