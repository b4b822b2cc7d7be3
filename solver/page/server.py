"""The page's server: who may talk to it, its files, and one websocket a tab with two workers behind it.

The token comes once in the address of the page and becomes a cookie that scripts cannot read. Every
request needs the cookie and, against DNS rebinding, a Host that is this machine. A websocket, and
every request that says where it comes from, must come from the page itself.

Of the two workers of a tab the quick one checks texts and answers while something is dragged; the
other one solves.
"""

from __future__ import annotations

import asyncio
import json
import logging
import os
import secrets
import socket
import webbrowser
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress
from hashlib import sha256
from http.cookies import CookieError, SimpleCookie
from pathlib import Path
from typing import Any, NamedTuple
from urllib.parse import parse_qs

import uvicorn
from starlette.applications import Starlette
from starlette.datastructures import Headers, MutableHeaders
from starlette.responses import FileResponse, PlainTextResponse, RedirectResponse, Response
from starlette.routing import Mount, Route, WebSocketRoute
from starlette.staticfiles import StaticFiles
from starlette.types import ASGIApp, Message, Receive, Scope, Send
from starlette.websockets import WebSocket, WebSocketDisconnect

from rulesheets.diagnosis import RuleSheetError
from rulesheets.files import MAIN_SHEET, read_source, shipped_model, shipped_models
from solver.files import write_file
from solver.lane import Lane, Workers
from solver.page.bench import QUICK, SLOW
from solver.page.description import complaint

LARGEST = 500_000
"""Characters of a sheet that a page takes."""

LISTED = 200
"""Sheets of the folder that are listed at most."""

SHIPPED = "shipped:"


class Refused(Exception):
    """A sheet that is not there, or not to be opened or written; the text says why."""


class Sheet(NamedTuple):
    """A sheet on the shelf, by its ``key``; what it uses lies ``within`` a folder."""

    key: str
    name: str
    file: Path
    within: Path

    def read(self) -> str:
        """The text. Raises Refused for one that is too long, RuleSheetError for one that cannot be read."""
        if self.file.is_file() and self.file.stat().st_size > LARGEST:
            raise Refused(f"{self.name} is too long for a page: it takes {LARGEST:,} bytes")
        return read_source(self.file).text

    def write(self, text: str, seen: str) -> None:
        """Replace the file, if it still says what the page has ``seen``. Raises Refused."""
        if self.key.startswith(SHIPPED):
            raise Refused("a sheet that comes with Backsolve is not written to; copy its folder first")
        if fingerprint(self.read()) != seen:
            raise Refused(f"{self.name} has changed on disk since it was opened")
        write_file(str(self.file), text.encode())


class Shelf:
    """Sheets by key: the path from the folder, or ``shipped:`` and the name of a shipped sheet."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder.resolve()

    def listed(self) -> list[dict[str, str]]:
        """Every sheet by key and name, those of the folder first."""
        found: list[dict[str, str]] = []
        for place, folders, files in os.walk(self.folder):
            folders[:] = sorted(name for name in folders if not name.startswith("."))
            for name in sorted(files):
                if name.endswith(".tk") and len(found) < LISTED:
                    key = (Path(place) / name).relative_to(self.folder).as_posix()
                    parent = os.path.dirname(key) or self.folder.name
                    found.append({"key": key, "name": parent if name == MAIN_SHEET else key})
        shipped = [{"key": SHIPPED + name, "name": name} for name in shipped_models()]
        return found + shipped

    def sheet(self, key: str) -> Sheet:
        """The sheet of that key. Raises Refused for one that is outside the folder."""
        if key.startswith(SHIPPED):
            name = key.removeprefix(SHIPPED)
            if name not in shipped_models():
                raise Refused("there is no such sheet")
            file = Path(shipped_model(name))
            return Sheet(key, name, file, file.parent.parent)
        if "\0" in key:
            raise Refused("there is no such sheet")
        file = (self.folder / key).resolve()
        if not file.is_relative_to(self.folder) or file.suffix != ".tk":
            raise Refused("a page opens the sheets in its folder alone")
        if not file.is_file():
            raise Refused(f"there is no sheet {key}")
        name = file.parent.name if file.name == MAIN_SHEET else file.stem
        return Sheet(key, name, file, self.folder)


def fingerprint(text: str) -> str:
    """Tells whether a text has changed."""
    return sha256(text.encode()).hexdigest()


POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data:; "
    "font-src 'self'; connect-src 'self'; base-uri 'none'; frame-ancestors 'none'; form-action 'none'"
)

HEADERS = {
    "content-security-policy": POLICY,
    "cross-origin-resource-policy": "same-origin",
    "referrer-policy": "no-referrer",
    "x-content-type-options": "nosniff",
    "cache-control": "no-store",
}


class Gate:
    """Wraps an application; ``hosts`` are the names under which it may be asked for."""

    def __init__(self, app: ASGIApp, token: str, hosts: frozenset[str]) -> None:
        self.app, self.token, self.hosts = app, token, hosts

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] not in ("http", "websocket"):
            await self.app(scope, receive, send)
            return
        headers = Headers(scope=scope)
        reason = self._foreign(scope, headers)
        given = parse_qs(scope.get("query_string", b"").decode("latin-1")).get("token", [""])[0]
        entering = scope["type"] == "http" and scope["method"] == "GET" and scope["path"] == "/"
        if reason is None and entering and self._right(given):
            response = RedirectResponse("/", 303)  # the token goes into a cookie and off the address
            name = _cookie_name(headers.get("host", ""))
            response.set_cookie(name, self.token, httponly=True, samesite="strict", path="/")
            await response(scope, receive, _guarded(send))
            return
        if reason is None and not self._known(headers):
            reason = "there is no token; open the address that backsolve printed"
        if reason is None:
            await self.app(scope, receive, _guarded(send))
            return
        _log.warning("refused %s %s: %s", scope["type"], scope["path"], reason)
        if scope["type"] == "websocket":
            await send({"type": "websocket.close", "code": 1008, "reason": ""})
        else:
            await PlainTextResponse(f"Refused: {reason}.\n", 403)(scope, receive, _guarded(send))

    def _foreign(self, scope: Scope, headers: Headers) -> str | None:
        """Why a request does not come from the page itself; None where it does."""
        host = headers.get("host", "")
        if host.rpartition(":")[0] not in self.hosts and host not in self.hosts:
            return "the host is not this machine"
        origin = headers.get("origin")
        if origin is None:
            return "a websocket says where it comes from" if scope["type"] == "websocket" else None
        return None if origin == f"http://{host}" else "it comes from another site"

    def _known(self, headers: Headers) -> bool:
        with suppress(CookieError):
            morsel = SimpleCookie(headers.get("cookie", "")).get(_cookie_name(headers.get("host", "")))
            return morsel is not None and self._right(morsel.value)
        return False

    def _right(self, given: str) -> bool:
        return secrets.compare_digest(given.encode(), self.token.encode())


def _cookie_name(host: str) -> str:
    """Cookies ignore ports, so the name holds it: two pages on one machine have two cookies."""
    return f"backsolve_{host.rpartition(':')[2]}"


def _guarded(send: Send) -> Send:
    """Sends answers with headers that keep the page to itself."""

    async def guarded(message: Message) -> None:
        if message["type"] == "http.response.start":
            MutableHeaders(scope=message).update(HEADERS)
        await send(message)

    return guarded


Json = dict[str, Any]

STATIC = Path(__file__).parent / "static"

OWN = "sheets", "open", "edit", "save", "keep"
"""What the server answers itself; the workers answer the rest."""

KEPT = 200_000
"""Characters of a tab's state that the server keeps for a sheet."""

_log = logging.getLogger("backsolve.page")


def application(
    folder: Path, token: str, *, first: str = "", hosts: frozenset[str], timeout: float
) -> ASGIApp:
    """The application for the sheets of a folder; ``first`` is the sheet that the page shows at first."""
    shelf, kept, workers = Shelf(folder), dict[str, Json](), Workers()
    leaving: set[asyncio.Task[None]] = set()

    async def index(_: object) -> Response:
        return FileResponse(STATIC / "index.html")

    async def talk(socket: WebSocket) -> None:
        await socket.accept()
        tab = Tab(socket, shelf, kept, first, workers, timeout)
        try:
            await tab.run()
        except WebSocketDisconnect:
            _log.debug("a tab was closed")
        finally:
            leaving.add(task := asyncio.create_task(tab.aclose()))
            task.add_done_callback(leaving.discard)

    @asynccontextmanager
    async def lifespan(_: object) -> AsyncIterator[None]:
        workers.ready()
        yield
        await asyncio.gather(*leaving)
        await workers.close()

    routes = [
        Route("/", index),
        Mount("/static", StaticFiles(directory=STATIC)),
        WebSocketRoute("/talk", talk),
    ]
    return Gate(Starlette(routes=routes, lifespan=lifespan), token, hosts)


class Tab:
    """One tab of a browser. Every message has a number, which its reply repeats; replies may overtake."""

    def __init__(
        self,
        socket: WebSocket,
        shelf: Shelf,
        kept: dict[str, Json],
        first: str,
        workers: Workers,
        timeout: float,
    ) -> None:
        self.socket, self.shelf, self.kept, self.first = socket, shelf, kept, first
        self.quick, self.slow = Lane(workers, timeout), Lane(workers, timeout)
        self.sheet: Sheet | None = None
        self.tasks: set[asyncio.Task[None]] = set()

    async def run(self) -> None:
        """Answer until the tab is closed."""
        while True:
            try:
                message = json.loads(await self.socket.receive_text())
            except (ValueError, RecursionError):
                message = None
            task = asyncio.create_task(self._reply(message if isinstance(message, dict) else {}))
            self.tasks.add(task)
            task.add_done_callback(self.tasks.discard)

    async def aclose(self) -> None:
        """End the workers and whatever waits for them."""
        for task in self.tasks:
            task.cancel()
        await asyncio.gather(*self.tasks, return_exceptions=True)
        await asyncio.gather(self.quick.stop(), self.slow.stop())

    async def _reply(self, message: Json) -> None:
        try:
            reply = await self._answer(message)
        except Refused as refused:
            _log.warning("refused %s: %s", message.get("do"), refused)
            reply = {"failed": str(refused)}
        except (KeyError, TypeError, ValueError) as wrong:
            _log.warning("refused %s: %r", message.get("do"), wrong)
            reply = {"failed": "this request makes no sense"}
        except RuleSheetError as wrong:
            reply = {"wrong": [complaint(diagnosis) for diagnosis in wrong.diagnoses]}
        with suppress(WebSocketDisconnect, RuntimeError):  # the tab may have been closed meanwhile
            await self.socket.send_text(json.dumps({**reply, "id": message.get("id")}))

    async def _answer(self, message: Json) -> Json:
        do = str(message.get("do"))
        if do in OWN:
            reply: Json = await getattr(self, do)(message)
            return reply
        if do not in (*QUICK, *SLOW):
            raise Refused("no such request")
        lane = self.quick if do in QUICK else self.slow
        return await lane.ask({**self._text(str(message["text"])), "do": do} if do == "check" else message)

    # --- sheets ---

    async def sheets(self, _: Json) -> Json:
        return {"sheets": self.shelf.listed(), "first": self.first, "folder": str(self.shelf.folder)}

    async def open(self, message: Json) -> Json:
        """Read a sheet and load it; ``kept`` is the state in which a tab left it."""
        self.sheet = self.shelf.sheet(str(message["sheet"]))
        text = self.sheet.read()
        kept = self.kept.get(self.sheet.key)
        told = {"sheet": self.sheet.key, "name": self.sheet.name, "text": text, "kept": kept}
        state = {"seen": fingerprint(text), "shipped": self.sheet.key.startswith(SHIPPED)}
        return {**await self._load(text), **told, **state}

    async def edit(self, message: Json) -> Json:
        """Take another text for the sheet, which is not written."""
        return await self._load(str(message["text"]))

    async def save(self, message: Json) -> Json:
        text = str(message["text"])
        self._text(text)
        assert self.sheet is not None
        self.sheet.write(text, str(message["seen"]))
        return {"seen": fingerprint(text)}

    async def keep(self, message: Json) -> Json:
        """Remember the state of a sheet for the next tab that opens it."""
        if self.sheet is not None and len(json.dumps(message["state"])) <= KEPT:
            self.kept[self.sheet.key] = message["state"]
        return {}

    async def _load(self, text: str) -> Json:
        sheet = self._text(text)
        reply = await self.slow.load(sheet)
        if "variables" in reply:
            self.quick.know(sheet)
        return reply

    def _text(self, text: str) -> Json:
        """A text as the workers take it. Raises Refused for one that is too long."""
        if self.sheet is None:
            raise Refused("no sheet is open")
        if len(text) > LARGEST:
            raise Refused(f"this text is too long for a page: it takes {LARGEST:,} characters")
        folder, within = str(self.sheet.file.parent), str(self.sheet.within)
        return {"text": text, "name": self.sheet.file.name, "base": folder, "within": within}


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
