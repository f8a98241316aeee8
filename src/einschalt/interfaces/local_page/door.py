"""Who may come in: this computer, with the key of the session, from its own pages.

Every request passes here, before anything of its body is read.
"""

import hmac
from http.cookies import CookieError, SimpleCookie
from urllib.parse import parse_qs

from starlette.responses import PlainTextResponse

from einschalt.foundations.language import translated
from einschalt.interfaces.local_page import words

NAMES = ("127.0.0.1", "localhost", "[::1]")
USUAL_PORT = 80  # browsers leave it out
LOOPBACK = ("127.0.0.1", "::1")
MOST_AT_ONCE = 64  # requests that are being answered
KEY = "key"  # of the address with which a session begins
SAFE = {"GET", "HEAD"}
POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; "
    "connect-src 'self'; frame-src 'self'; form-action 'self'; base-uri 'none'; "
    "frame-ancestors 'self'"
)
HEADERS = {
    "content-security-policy": POLICY,
    "x-content-type-options": "nosniff",
    # no-referrer would take the origin away from forms, by which they are known
    "referrer-policy": "same-origin",
    "cross-origin-opener-policy": "same-origin",
    "cross-origin-resource-policy": "same-origin",
    "cache-control": "no-store",
}


class Door:
    """Middleware that lets in who has the key, and sees to the headers of answers.

    ``port`` is known when the server listens; names of other hosts are refused, so that
    no name server can lead a foreign page here.
    """

    def __init__(self, app, key, port):
        self.app = app
        self.key = key
        self.port = port
        self.n_inside = 0

    @property
    def cookie(self):
        """Name of the cookie: other servers of this computer have other ports."""
        return f"einschalt-{self.port}"

    async def __call__(self, scope, receive, send):
        """Answer a request, or refuse it."""
        if scope["type"] == "lifespan":
            await self.app(scope, receive, send)
            return
        if scope["type"] != "http":  # a web socket: none is offered
            await send({"type": "websocket.close", "code": 1008})
            return
        send = _with_headers(send)
        refusal = self._refusal(scope)
        if refusal is None and self.n_inside >= MOST_AT_ONCE:
            refusal = _refused(503, words.TOO_MANY_REQUESTS, {"retry-after": "1"})
        if refusal is not None:
            await refusal(scope, receive, send)
            return
        self.n_inside += 1
        try:
            await self.app(scope, receive, send)
        finally:
            self.n_inside -= 1

    def _refusal(self, scope):
        """The answer to a request that may not come in; None to others."""
        headers = {}
        for name, value in scope["headers"]:
            headers.setdefault(name.decode("latin-1"), value.decode("latin-1"))
        host = headers.get("host", "")
        if host not in self._hosts():
            return _refused(403, words.WRONG_HOST)
        origin = headers.get("origin")
        is_safe = scope["method"] in SAFE
        if origin != f"http://{host}" and not (origin is None and is_safe):
            return _refused(403, words.WRONG_ORIGIN)
        is_from_elsewhere = headers.get("sec-fetch-site") in ("cross-site", "same-site")
        if is_from_elsewhere and headers.get("sec-fetch-mode") != "navigate":
            return _refused(403, words.WRONG_ORIGIN)
        if self._is_known(scope, headers):
            return None
        return _refused(403, words.NO_KEY)

    def _hosts(self):
        hosts = {f"{name}:{self.port}" for name in NAMES}
        return hosts | {*NAMES} if self.port == USUAL_PORT else hosts

    def _is_known(self, scope, headers):
        if scope["path"] == "/" and scope["method"] == "GET":
            query = parse_qs(scope["query_string"].decode("latin-1"))
            if self.is_key(query.get(KEY, [""])[0]):
                return True
        try:
            cookies = SimpleCookie(headers.get("cookie", ""))
        except CookieError:
            return False
        return self.cookie in cookies and self.is_key(cookies[self.cookie].value)

    def is_key(self, text):
        """Whether a text is the key; it takes as long for every text."""
        given = text.encode("utf-8", errors="replace")
        return hmac.compare_digest(given, self.key.encode("ascii"))


def _refused(status, text, headers=None):
    return PlainTextResponse(f"{translated(text)}\n", status, headers)


def _with_headers(send):
    """Send answers with the headers of the page, where they have none of their own."""

    async def sent(message):
        if message["type"] == "http.response.start":
            headers = list(message.get("headers", ()))
            present = {name.lower() for name, _ in headers}
            headers += [
                (name.encode("ascii"), value.encode("ascii"))
                for name, value in HEADERS.items()
                if name.encode("ascii") not in present
            ]
            message = {**message, "headers": headers}
        await send(message)

    return sent
