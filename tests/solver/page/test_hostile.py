"""A running server, and strangers on the same machine: refused, logged without the token, alive."""

from __future__ import annotations

import http.client
import json
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import parse_qs, urlsplit

import pytest

pytest.importorskip("uvicorn")
pytest.importorskip("websockets")

from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import ClientConnection, connect

ROOT = Path(__file__).parent.parent.parent.parent


class Server:
    def __init__(self, folder: Path) -> None:
        command = [sys.executable, "-m", "solver", "open", "--no-browser", "--timeout", "20"]
        environment = {**os.environ, "PYTHONPATH": str(ROOT)}
        with (folder.parent / "log").open("w") as log:
            self.process = subprocess.Popen(
                command, cwd=folder, env=environment, stdout=subprocess.PIPE, stderr=log, text=True
            )
        self.log = folder.parent / "log"
        assert self.process.stdout is not None
        parts = urlsplit(self.process.stdout.readline().strip())
        self.port, self.token = parts.port, parse_qs(parts.query)["token"][0]

    def get(self, path: str, **headers: str) -> http.client.HTTPResponse:
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=20)
        connection.request("GET", path, headers=headers)
        answer = connection.getresponse()
        answer.read()
        connection.close()
        return answer

    def talk(self, cookie: str = "", origin: str = "") -> ClientConnection:
        headers = {"Cookie": cookie, "Origin": origin or f"http://127.0.0.1:{self.port}"}
        return connect(
            f"ws://127.0.0.1:{self.port}/talk",
            additional_headers=headers,
            proxy=None,
            open_timeout=20,
        )

    @property
    def cookie(self) -> str:
        return f"backsolve_{self.port}={self.token}"


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    folder = tmp_path_factory.mktemp("outer") / "sheets"
    folder.mkdir()
    (folder / "ohm.tk").write_text("V = 3\nI = 2\nV = I*R\n")
    running = Server(folder)
    yield running
    running.process.send_signal(signal.SIGINT)
    running.process.communicate(timeout=20)


def alive(server: Server) -> bool:
    with server.talk(server.cookie) as tab:
        tab.send(json.dumps({"id": 1, "do": "open", "sheet": "ohm.tk"}))
        return bool(json.loads(tab.recv(timeout=60))["sheet"] == "ohm.tk")


def test_only_this_machine_can_reach_it(server: Server) -> None:
    listening = Path("/proc/net/tcp")
    if not listening.exists():
        pytest.skip("this system does not list its sockets")
    own = [
        line.split()[1]
        for line in listening.read_text().splitlines()[1:]
        if line.split()[3] == "0A"
    ]
    assert f"0100007F:{server.port:04X}" in own
    assert f"00000000:{server.port:04X}" not in own


def test_the_token_opens_the_door_once_and_is_a_cookie_then(server: Server) -> None:
    answer = server.get(f"/?token={server.token}")
    assert (answer.status, answer.getheader("location")) == (303, "/")
    assert server.get("/", Cookie=server.cookie).status == 200


@pytest.mark.parametrize(
    ("cookie", "origin"),
    [
        ("", ""),
        ("right", "http://evil.example"),
        ("right", "http://localhost:1"),
        ("wrong", ""),
        ("right", "null"),
    ],
)
def test_a_foreign_websocket_is_not_accepted(server: Server, cookie: str, origin: str) -> None:
    sent = {"right": server.cookie, "wrong": server.cookie[:-1] + "!"}.get(cookie, "")
    with pytest.raises(InvalidStatus) as refused, server.talk(sent, origin):
        pass
    assert refused.value.response.status_code == 403
    assert alive(server)


@pytest.mark.parametrize("host", ["evil.example", "127.0.0.1.nip.io", "169.254.169.254", ""])
def test_a_rebound_name_gets_nothing(server: Server, host: str) -> None:
    assert server.get("/", Host=host, Cookie=server.cookie).status in (400, 403)


@pytest.mark.parametrize(
    "path", ["/static/../lane.py", "/static/%2e%2e/lane.py", "//etc/passwd", "/talk"]
)
def test_no_path_leads_out(server: Server, path: str) -> None:
    assert server.get(path, Cookie=server.cookie).status == 404


def test_a_message_of_two_megabytes_ends_its_tab_alone(server: Server) -> None:
    with server.talk(server.cookie) as tab:
        tab.send("x" * 2_000_000)
        with pytest.raises(ConnectionClosed) as closed:
            tab.recv(timeout=20)
        assert closed.value.rcvd is not None and closed.value.rcvd.code == 1009
    assert alive(server)


def test_refusals_are_logged_without_the_token(server: Server) -> None:
    server.get(f"/other?token={server.token}")
    assert server.get("/?token=wrong").status == 403
    log = server.log.read_text()
    assert "refused" in log and server.token not in log and "token=" not in log
