"""Serve the page on this machine until it is interrupted."""

from __future__ import annotations

import secrets
import socket
import webbrowser
from pathlib import Path

import uvicorn

from solver.page.app import application

LOOPBACK = frozenset({"127.0.0.1", "localhost", "[::1]"})

MESSAGE = 2**20
"""Bytes of a message from the page."""


def serve(folder: Path, first: str, *, host: str, port: int, timeout: float, browse: bool) -> None:
    """Print the address with its token, and serve."""
    token = secrets.token_urlsafe(32)
    with socket.create_server((host, port)) as listener:
        name, port = listener.getsockname()[:2]
        hosts = LOOPBACK if name in LOOPBACK else LOOPBACK | {host, name}
        app = application(folder, token, first=first, hosts=hosts, timeout=timeout)
        address = f"http://{'127.0.0.1' if name == '0.0.0.0' else name}:{port}/?token={token}"
        print(address, flush=True)
        if browse:
            webbrowser.open(address)
        config = uvicorn.Config(
            app, log_level="warning", access_log=False, ws_max_size=MESSAGE, timeout_graceful_shutdown=1
        )
        uvicorn.Server(config).run(sockets=[listener])
