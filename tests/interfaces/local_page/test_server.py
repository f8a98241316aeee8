"""The port of the local page: taken again at once, and refused with a remedy."""

import contextlib
import os
import socket

import pytest

pytest.importorskip("starlette", reason="the extra serve is not installed")
pytest.importorskip("uvicorn", reason="the extra serve is not installed")

from einschalt.foundations.errors import SettingsError
from einschalt.interfaces.local_page.server import _listening

HOST = "127.0.0.1"


def left_by_a_server_that_ended():
    """A port whose last connection was closed by its server, which is gone."""
    with contextlib.closing(_listening(HOST, 0)) as listener:
        port = listener.getsockname()[1]
        with socket.create_connection((HOST, port)) as client:
            held, _ = listener.accept()
            held.close()
            assert client.recv(1) == b""
    return port


@pytest.mark.skipif(os.name != "posix", reason="Windows has no such wait")
def test_a_port_is_taken_again_at_once():
    """It was refused for a minute after a server with a browser had ended."""
    port = left_by_a_server_that_ended()
    with contextlib.closing(_listening(HOST, port)) as again:
        assert again.getsockname()[1] == port


def test_a_port_in_use_is_named_with_its_remedy():
    with contextlib.closing(_listening(HOST, 0)) as listener:
        port = listener.getsockname()[1]
        with pytest.raises(SettingsError) as refused:
            _listening(HOST, port)
    assert str(refused.value).startswith(f"--port = {port} on {HOST}: ")
    assert "leave it out" in refused.value.remedy
