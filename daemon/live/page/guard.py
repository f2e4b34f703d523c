"""Who may ask the page's server: whoever has its token, from the page itself, at this machine's own address.

The token is in the address that `longreach ui` prints, behind `#`, which a browser keeps to itself: the page sends it along. Pages of
others cannot know it; their requests are refused for their origin too, and a name of theirs that leads here (DNS rebinding) as no
address of ours.
"""

from __future__ import annotations

import hmac
from dataclasses import dataclass

from starlette.datastructures import Headers, MutableHeaders
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from config.errors import DaemonError

HEADERS = {
    "Content-Security-Policy": "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src 'self';"
    " base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-store",
}
REPORT_POLICY = "default-src 'none'; style-src 'unsafe-inline'; img-src data:; sandbox; frame-ancestors 'none'"


class RequestError(DaemonError):
    """A request that the page's server does not even pass on. `status`: of HTTP."""

    def __init__(self, status: int, what: str, next_step: str = "") -> None:
        super().__init__(what, next_step=next_step)
        self.status = status


@dataclass(frozen=True, slots=True)
class Guard:
    """`control`: whether the page may also arm, move and stop."""

    token: str
    port: int
    control: bool = False

    def check_host(self, headers: Headers) -> None:
        """RequestError for a request that was sent to another name."""
        if headers.get("host") not in self._own():
            raise RequestError(403, "this is no address of the page", f"Open http://127.0.0.1:{self.port}/.")

    def check_place(self, headers: Headers) -> None:
        """RequestError for a request that was not sent to this server by its own page. Programs other than browsers name no origin."""
        self.check_host(headers)
        origin = headers.get("origin")
        if origin is not None and origin not in {f"http://{own}" for own in self._own()}:
            raise RequestError(403, "requests of another page are refused")
        if headers.get("sec-fetch-site", "none") not in ("same-origin", "none"):
            raise RequestError(403, "requests of another page are refused")

    def check_token(self, token: object) -> None:
        """RequestError for anything but the token."""
        if not isinstance(token, str) or not hmac.compare_digest(token.encode(), self.token.encode()):
            raise RequestError(401, "the token is missing or wrong", "Open the address that `longreach ui` prints.")

    def check_request(self, headers: Headers) -> None:
        """Place and token of a request over HTTP."""
        self.check_place(headers)
        kind, _, token = headers.get("authorization", "").partition(" ")
        self.check_token(token if kind.lower() == "bearer" else "")

    def _own(self) -> set[str]:
        return {f"127.0.0.1:{self.port}", f"localhost:{self.port}"}


def with_headers(application: ASGIApp) -> ASGIApp:
    """The application with HEADERS in every answer over HTTP, but for those that an answer sets itself."""

    async def answer(scope: Scope, receive: Receive, send: Send) -> None:
        async def send_with_headers(message: Message) -> None:
            if message["type"] == "http.response.start":
                headers = MutableHeaders(scope=message)
                for name, value in HEADERS.items():
                    headers.setdefault(name, value)
            await send(message)

        await application(scope, receive, send_with_headers if scope["type"] == "http" else send)

    return answer
