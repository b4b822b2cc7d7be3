"""The page's server: static files, and one websocket a tab with two workers behind it.

The quick worker checks texts and answers while something is dragged; the other one solves.
"""

from __future__ import annotations

import asyncio
import json
import logging
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager, suppress
from pathlib import Path
from typing import Any

from starlette.applications import Starlette
from starlette.responses import FileResponse, Response
from starlette.routing import Mount, Route, WebSocketRoute
from starlette.staticfiles import StaticFiles
from starlette.types import ASGIApp
from starlette.websockets import WebSocket, WebSocketDisconnect

from rulesheets.diagnosis import RuleSheetError
from solver.page.description import complaint
from solver.page.gate import Gate
from solver.page.lane import Lane, Workers
from solver.page.shelf import LARGEST, Refused, Sheet, Shelf, fingerprint

Json = dict[str, Any]

STATIC = Path(__file__).parent / "static"

QUICK = frozenset({"check", "value", "frame", "warm"})
SLOW = frozenset({"solve", "typeset", "motion", "rail", "swap", "sweep", "sensitivity", "why"})

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
        self.own: dict[str, Callable[[Json], Awaitable[Json]]] = {
            "sheets": self.sheets,
            "open": self.open,
            "edit": self.edit,
            "save": self.save,
            "keep": self.keep,
        }

    async def run(self) -> None:
        """Answer until the tab is closed."""
        while True:
            message = _message(await self.socket.receive_text())
            task = asyncio.create_task(self._reply(message))
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
        if do in self.own:
            return await self.own[do](message)
        if do == "check":
            return await self.quick.ask({**self._text(str(message["text"])), "do": "check"})
        if do in QUICK:
            return await self.quick.ask(message)
        if do in SLOW:
            return await self.slow.ask(message)
        raise Refused("no such request")

    # --- sheets ---

    async def sheets(self, _: Json) -> Json:
        return {"sheets": self.shelf.listed(), "first": self.first, "folder": str(self.shelf.folder)}

    async def open(self, message: Json) -> Json:
        """Read a sheet and load it; ``kept`` is the state in which a tab left it."""
        self.sheet = self.shelf.sheet(str(message["sheet"]))
        text = self.sheet.read()
        kept = self.kept.get(self.sheet.key)
        told = {"sheet": self.sheet.key, "name": self.sheet.name, "text": text, "kept": kept}
        state = {"seen": fingerprint(text), "shipped": self.sheet.shipped}
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
        folder, within = str(self.sheet.folder), str(self.sheet.within)
        return {"text": text, "name": self.sheet.file.name, "base": folder, "within": within}


def _message(text: str) -> Json:
    """What a tab has sent; an empty object for what is none."""
    try:
        message = json.loads(text)
    except (ValueError, RecursionError):
        return {}
    return message if isinstance(message, dict) else {}
