"""The page's server: access control, its files, and one websocket for each tab with two workers.

The token comes once in the address of the page and becomes a cookie that scripts cannot read. Every
request needs the cookie and, against DNS rebinding, a Host that is this machine. A websocket, and
every request that states its origin, must come from the page itself.

Of the two workers of a tab the quick one checks texts and serves drags; one solves.
"""

from __future__ import annotations

import asyncio
import json
import logging
import secrets
import socket
import webbrowser
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress
from dataclasses import dataclass
from hashlib import sha256
from itertools import islice
from pathlib import Path
from typing import Any, NamedTuple

import uvicorn
from starlette.applications import Starlette
from starlette.datastructures import MutableHeaders
from starlette.requests import HTTPConnection
from starlette.responses import FileResponse, PlainTextResponse, RedirectResponse, Response
from starlette.routing import Mount, Route, WebSocketRoute
from starlette.staticfiles import StaticFiles
from starlette.types import ASGIApp, Message, Receive, Scope, Send
from starlette.websockets import WebSocket, WebSocketDisconnect

from rulesheets.diagnosis import RuleSheetError
from rulesheets.files import MAIN_SHEET, read_source, shipped_model, shipped_models
from solver.files import write_file
from solver.lane import Json, Lane, Workers
from solver.page.bench import QUICK, SLOW
from solver.page.description import STATIC, complaint

LARGEST = 500_000
"""Characters of a sheet that a page takes."""

LISTED = 200
"""Sheets of the folder that are listed at most."""

SHIPPED = "shipped:"
"""Keys of sheets are paths from the folder; of shipped ones, this and their names."""


class Refused(Exception):
    """A sheet is missing, or must not be opened or written; the text says why."""


class Sheet(NamedTuple):
    """A sheet by its ``key``; what it uses lies ``within`` a folder."""

    key: str
    name: str
    file: Path
    within: Path

    def write(self, text: str, seen: str) -> None:
        """Replace the file, if its text is still what the page has ``seen``. Raises Refused."""
        if self.key.startswith(SHIPPED):
            cure = "copy its folder first"
            raise Refused(f"a sheet that comes with Backsolve is not written to; {cure}")
        if (fingerprint(read_source(self.file).text) if self.file.exists() else "") != seen:
            raise Refused(f"{self.name} has changed on disk since it was opened")
        write_file(str(self.file), text.encode())


NEW = """" A new sheet: variables with a value are inputs, the others are solved for

variables
  a = 3      [m]  " one side
  b = 4      [m]  " the other side
  c     >= 0 [m]  " the diagonal

rules
  c^2 = a^2 + b^2
"""
"""The text that a sheet begins with whose file does not exist yet."""


def listed(folder: Path) -> list[dict[str, str]]:
    """Every sheet by key and name, those of the folder first."""
    paths = (file.relative_to(folder) for file in sorted(folder.rglob("*.tk")))
    found: list[dict[str, str]] = []
    shown = (path for path in paths if not any(part.startswith(".") for part in path.parts))
    for path in islice(shown, LISTED):
        key, parent = path.as_posix(), path.parent.as_posix() if path.parent.name else folder.name
        found.append({"key": key, "name": parent if path.name == MAIN_SHEET else key})
    return found + [{"key": SHIPPED + name, "name": name} for name in shipped_models()]


def sheet_of(key: str, folder: Path, first: str = "") -> Sheet:
    """The sheet of that key; the ``first`` one may be new. Raises Refused for one that is outside
    the folder."""
    name = key.removeprefix(SHIPPED)
    if "\0" in key or (name != key and name not in shipped_models()):
        raise Refused("there is no such sheet")
    if name != key:
        file = Path(shipped_model(name))
        return Sheet(key, name, file, file.parent.parent)
    file = (folder / key).resolve()
    if not file.is_relative_to(folder) or file.suffix != ".tk":
        raise Refused("a page opens the sheets in its folder alone")
    if not file.is_file() and (key != first or file.exists()):
        raise Refused(f"there is no sheet {key}")
    return Sheet(key, file.parent.name if file.name == MAIN_SHEET else file.stem, file, folder)


def fingerprint(text: str) -> str:
    """A hash that identifies a text."""
    return sha256(text.encode()).hexdigest()


POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; "
    "img-src 'self' data:; font-src 'self'; connect-src 'self'; base-uri 'none'; "
    "frame-ancestors 'none'; form-action 'none'"
)

HEADERS = {
    "content-security-policy": POLICY,
    "cross-origin-resource-policy": "same-origin",
    "referrer-policy": "no-referrer",
    "x-content-type-options": "nosniff",
    "cache-control": "no-store",
}
"""Headers that isolate the page from other sites."""


@dataclass(frozen=True)
class Gate:
    """Wraps an application; ``hosts`` are the accepted names of this machine."""

    app: ASGIApp
    token: str
    hosts: frozenset[str]

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        async def guarded(message: Message) -> None:
            if message["type"] == "http.response.start":
                MutableHeaders(scope=message).update(HEADERS)
            await send(message)

        answer: ASGIApp | None = self.app
        if (kind := scope["type"]) in ("http", "websocket"):
            asked = HTTPConnection(scope)
            # cookies ignore ports, so the name holds it: two pages on one machine have two cookies
            cookie = f"backsolve_{asked.headers.get('host', '').rpartition(':')[2]}"
            entering = kind == "http" and scope["method"] == "GET" and scope["path"] == "/"
            reason = self._foreign(asked)
            if reason is None and entering and self._right(asked.query_params.get("token", "")):
                answer = welcome = RedirectResponse("/", 303)  # the token leaves the address
                welcome.set_cookie(cookie, self.token, httponly=True, samesite="strict", path="/")
            elif reason is None and not self._right(asked.cookies.get(cookie, "")):
                reason = "there is no token; open the address that backsolve printed"
            if reason is not None:
                _log.warning("refused %s %s: %s", kind, scope["path"], reason)
                answer = PlainTextResponse(f"Refused: {reason}.\n", 403) if kind == "http" else None
        if answer is not None:
            await answer(scope, receive, guarded)
        else:
            await send({"type": "websocket.close", "code": 1008, "reason": ""})

    def _foreign(self, asked: HTTPConnection) -> str | None:
        """Why a request does not come from the page itself; None if it does."""
        host, origin = asked.headers.get("host", ""), asked.headers.get("origin")
        if host.rpartition(":")[0] not in self.hosts and host not in self.hosts:
            return "the host is not this machine"
        if origin is None:
            silent = "a websocket says where it comes from"
            return silent if asked.scope["type"] == "websocket" else None
        return None if origin == f"http://{host}" else "it comes from another site"

    def _right(self, given: str) -> bool:
        return secrets.compare_digest(given.encode(), self.token.encode())


OWN = "sheets", "open", "edit", "save", "keep"
"""Messages that the server answers itself; the workers answer the others."""

KEPT = 200_000
"""Characters of a tab's state that the server keeps for a sheet."""

_log = logging.getLogger("backsolve.page")


def application(
    folder: Path, token: str, *, first: str = "", hosts: frozenset[str], timeout: float
) -> ASGIApp:
    """The application for the sheets of a folder; ``first`` is the one that is shown first."""
    kept, workers, leaving = dict[str, Json](), Workers(), set[asyncio.Future[Any]]()

    async def index(_: object) -> Response:
        return FileResponse(STATIC / "index.html")

    async def talk(socket: WebSocket) -> None:
        await socket.accept()
        lanes = Lane(workers, timeout), Lane(workers, timeout)
        tab = Tab(socket, folder.resolve(), first, kept, *lanes)
        try:
            async with asyncio.TaskGroup() as replies:
                await tab.run(replies)
        except* WebSocketDisconnect:
            _log.debug("a tab was closed")
        finally:
            leaving.add(asyncio.gather(tab.quick.stop(), tab.slow.stop()))

    @asynccontextmanager
    async def lifespan(_: object) -> AsyncIterator[None]:
        workers.ready()
        yield
        await asyncio.gather(*leaving)
        await workers.close()

    static = Mount("/static", StaticFiles(directory=STATIC))
    routes = [Route("/", index), static, WebSocketRoute("/talk", talk)]
    return Gate(Starlette(routes=routes, lifespan=lifespan), token, hosts)


@dataclass
class Tab:
    """One tab of a browser. Messages are numbered: replies, with their numbers, may overtake."""

    socket: WebSocket
    folder: Path
    first: str
    kept: dict[str, Json]
    quick: Lane
    slow: Lane
    sheet: Sheet | None = None
    right: Json | None = None
    """The last text that was a sheet, as the workers take it."""

    async def run(self, replies: asyncio.TaskGroup) -> None:
        """Answer until the tab is closed."""
        while True:
            try:
                message = json.loads(await self.socket.receive_text())
            except (ValueError, RecursionError):
                message = None
            replies.create_task(self._reply(message if isinstance(message, dict) else {}))

    async def _reply(self, message: Json) -> None:
        try:
            reply = await self._answer(message)
        except Refused as refused:
            _log.warning("refused %s: %s", message.get("do"), refused)
            reply = {"failed": str(refused)}
        except (KeyError, TypeError, ValueError) as wrong:
            _log.warning("refused %s: %r", message.get("do"), wrong)
            reply = {"failed": "this request is not valid"}
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
        more = self._text(message) if do == "check" else {"sheet": self.right}
        return await lane.ask({**message, **more})

    # --- sheets ---

    async def sheets(self, _: Json) -> Json:
        found, first = listed(self.folder), {"key": self.first, "name": self.first}
        if self.first and all(one["key"] != self.first for one in found):
            found.insert(0, first)
        return {"sheets": found, "first": self.first, "folder": str(self.folder)}

    async def open(self, message: Json) -> Json:
        """Read a sheet and load it; ``kept`` is the last state of it in a tab. Of a new one nothing
        was ``seen``."""
        self.sheet = sheet = sheet_of(str(message["sheet"]), self.folder, self.first)
        old, shipped = sheet.file.exists(), sheet.key.startswith(SHIPPED)
        text = read_source(sheet.file).text if old else NEW
        kept = self.kept.get(sheet.key)
        told = {"sheet": sheet.key, "name": sheet.name, "text": text, "kept": kept}
        seen = fingerprint(text) if old else ""
        return {**await self.edit(told), **told, "seen": seen, "shipped": shipped}

    async def edit(self, message: Json) -> Json:
        """Use another text for the sheet, which is not written."""
        sheet = self._text(message)
        reply = await self.slow.ask({**sheet, "do": "load"})
        if "variables" in reply:
            self.right = sheet
        return reply

    async def save(self, message: Json) -> Json:
        text = str(self._text(message)["text"])
        assert self.sheet is not None
        self.sheet.write(text, str(message["seen"]))
        return {"seen": fingerprint(text)}

    async def keep(self, message: Json) -> Json:
        """Remember the state of a sheet for the next tab that opens it."""
        if self.sheet is not None and len(json.dumps(message["state"])) <= KEPT:
            self.kept[self.sheet.key] = message["state"]
        return {}

    def _text(self, message: Json) -> Json:
        """The text of a message for the workers. Raises Refused for one that is too long."""
        text = str(message["text"])
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
        limits: dict[str, Any] = {"ws_max_size": MESSAGE, "timeout_graceful_shutdown": 1}
        config = uvicorn.Config(app, log_level="warning", access_log=False, **limits)
        uvicorn.Server(config).run(sockets=[listener])
