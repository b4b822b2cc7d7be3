"""Who may talk to the page: this machine, from a page of its own, with the token that was printed.

The token comes once in the address of the page and becomes a cookie that scripts cannot read. Every
request needs the cookie and, against DNS rebinding, a Host that is this machine. A websocket, and
every request that says where it comes from, must come from the page itself.
"""

from __future__ import annotations

import logging
import secrets
from http.cookies import CookieError, SimpleCookie
from urllib.parse import parse_qs

from starlette.datastructures import Headers, MutableHeaders
from starlette.responses import PlainTextResponse, RedirectResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

_log = logging.getLogger("backsolve.page")

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
        if reason is None and scope["type"] == "http" and self._entering(scope):
            await self._welcome(scope, receive, _guarded(send))
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

    def _entering(self, scope: Scope) -> bool:
        """Whether the address holds the token."""
        given = parse_qs(scope.get("query_string", b"").decode("latin-1")).get("token", [""])[0]
        return scope["method"] == "GET" and scope["path"] == "/" and self._right(given)

    async def _welcome(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Put the token into a cookie and take it off the address."""
        response = RedirectResponse("/", 303)
        name = _cookie_name(Headers(scope=scope).get("host", ""))
        response.set_cookie(name, self.token, httponly=True, samesite="strict", path="/")
        await response(scope, receive, send)

    def _known(self, headers: Headers) -> bool:
        try:
            cookies = SimpleCookie(headers.get("cookie", ""))
        except CookieError:
            return False
        morsel = cookies.get(_cookie_name(headers.get("host", "")))
        return morsel is not None and self._right(morsel.value)

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
