"""Who is let in, and who is not."""

import asyncio

import pytest
from tests.interfaces.local_page.conftest import PORT, Visitor

from einschalt.interfaces.local_page import door, words


@pytest.fixture
def visitor(visit, root):
    return visit(root)


def test_the_key_of_the_address_becomes_a_cookie_that_scripts_cannot_read(visitor):
    visitor.headers.pop("cookie")
    answer = visitor.get(f"/?key={visitor.session.key}")
    assert answer.status == 200
    cookie = answer.headers["set-cookie"]
    assert cookie.startswith(f"einschalt-{PORT}={visitor.session.key};")
    assert "HttpOnly" in cookie
    assert "SameSite=strict" in cookie


@pytest.mark.parametrize(
    "headers",
    [
        {"cookie": None},
        {"cookie": f"einschalt-{PORT}=guessed"},
        {"cookie": f"einschalt-{PORT}=Öl"},
        {"cookie": "\x01=;;"},
        {"host": "evil.example:8417"},  # a name that leads here
        {"host": "127.0.0.1:1"},
        {"host": None},
        {"origin": "http://evil.example"},
        {"origin": "null"},
        {"origin": f"http://localhost:{PORT}"},  # another origin than the host asked
        {"sec-fetch-site": "cross-site", "sec-fetch-mode": "no-cors"},
        {"sec-fetch-site": "same-site", "sec-fetch-mode": "cors"},  # another port
    ],
)
def test_strangers_see_nothing(visitor, headers):
    answer = visitor.get("/", **headers)
    assert answer.status == 403
    assert "Open a block" not in answer.text
    assert "default-src 'none'" in answer.headers["content-security-policy"]


@pytest.mark.parametrize("origin", [None, "null", "http://evil.example"])
def test_forms_of_other_pages_are_refused_before_they_are_read(visitor, origin):
    answer = visitor.post("/quit", {"x": "y"}, origin=origin)
    assert (answer.status, answer.text.strip()) == (403, words.WRONG_ORIGIN)
    assert visitor.n_sent == 0


def test_own_pages_may_be_seen_under_all_names_of_this_computer(visitor):
    for name in ("127.0.0.1", "localhost", "[::1]"):
        assert visitor.get("/", host=f"{name}:{PORT}").status == 200


@pytest.mark.parametrize("host", ["localhost", "127.0.0.1:80"])
def test_the_usual_port_may_be_left_out_by_browsers(visitor, host):
    from einschalt.interfaces.local_page.server import application

    usual = Visitor(visitor.session, application(visitor.session, 80))
    usual.headers["cookie"] = f"einschalt-80={visitor.session.key}"
    assert usual.get("/", host=host, origin=f"http://{host}").status == 200
    assert usual.get("/", host="evil.example").status == 403
    assert visitor.get("/", host="localhost").status == 403


def test_200_requests_at_once_are_answered_or_told_to_wait(visitor):
    async def all_at_once():
        requests = [visitor.answer("GET", "/", (), {}) for _ in range(200)]
        return await asyncio.gather(*requests)

    answers = [answer.status for answer in asyncio.run(all_at_once())]
    assert set(answers) == {200, 503}
    assert answers.count(200) == door.MOST_AT_ONCE
    assert visitor.get("/").status == 200


def test_every_answer_forbids_scripts_and_requests_from_elsewhere(visitor):
    for address in ("/", "/static/run.js", "/nothing", "/block?path=nothing"):
        headers = visitor.get(address).headers
        policy = headers["content-security-policy"]
        assert policy == door.POLICY
        assert "unsafe" not in policy
        assert headers["x-content-type-options"] == "nosniff"
