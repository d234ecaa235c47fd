"""Which requests are answered, and what is logged of others: no browser is trusted."""

import logging
import re
import sys
from http import HTTPStatus

from websockets.asyncio.server import ServerConnection
from websockets.datastructures import Headers
from websockets.http11 import Request, Response

from peg_on_hole_ros.safe_text import cut, printable, shown
from peg_on_hole_ros.startup.exit_codes import PROGRAM, described

STREAM = "/stream"
LOOPBACK = ("127.0.0.1", "localhost", "::1")
_HOST = re.compile(r"(?:\[([0-9A-Fa-f:.]+)\]|([A-Za-z0-9._-]+))(?::[0-9]{1,5})?")
_LONGEST_LINE = 300


def answer(host: str, page: str, request: Request) -> Response | None:
    """
    Return the answer to a request; None: it is the stream.

    Parameters
    ----------
    host : str
        Address that is served: on loopback, other names in `Host` are other sites' that lead here.
    page : str
        HTML.
    request : Request
        Of which anything may be malformed, but for the syntax of HTTP.

    """
    # Only newer releases of websockets accept other methods.
    method = getattr(request, "method", "GET")
    if method != "GET":
        return _refused(HTTPStatus.METHOD_NOT_ALLOWED, f"method {shown(method)} is not GET")
    hosts, origins = (request.headers.get_all(name) for name in ("Host", "Origin"))
    for name, values, least in (("Host", hosts, 1), ("Origin", origins, 0)):
        if not least <= len(values) <= 1:
            return _refused(HTTPStatus.BAD_REQUEST, f"{len(values)} headers {name}, not one")
    found = _HOST.fullmatch(hosts[0])
    if not found:
        return _refused(HTTPStatus.BAD_REQUEST, f"Host {shown(hosts[0])} is no name of a host")
    if host in LOOPBACK and (found[1] or found[2]).lower() not in LOOPBACK:
        return _refused(HTTPStatus.FORBIDDEN, f"Host {shown(hosts[0])} is not this host")
    path = request.path.partition("?")[0]
    if path == STREAM:
        if origins and origins[0].partition("://")[2] != hosts[0]:
            return _refused(HTTPStatus.FORBIDDEN, f"Origin {shown(origins[0])} is another site")
        return None
    if path == "/":
        return _response(HTTPStatus.OK, "text/html; charset=utf-8", page)
    return _refused(HTTPStatus.NOT_FOUND, f"{shown(path)} is not here")


def _refused(status, why):
    response = _response(status, "text/plain; charset=utf-8", why)
    if status is HTTPStatus.METHOD_NOT_ALLOWED:
        response.headers["Allow"] = "GET"
    return response


def _response(status, kind, text):
    body = text.encode()
    headers = Headers(
        {
            "Content-Type": kind,
            "Content-Length": str(len(body)),
            "Cache-Control": "no-store",
            "X-Content-Type-Options": "nosniff",
            "Connection": "close",
        }
    )
    return Response(status.value, status.phrase, headers, body)


class Connection(ServerConnection):
    """A connection that logs a line where no request could be read from what came."""

    def connection_lost(self, exc: Exception | None) -> None:
        """Log what was wrong; browsers also connect ahead, and never send a request."""
        super().connection_lost(exc)
        failed = self.protocol.handshake_exc
        why = failed.__cause__ or failed if failed else None
        if self.request is None and why and not isinstance(why, EOFError):
            _log(f"a request is refused, it is no HTTP that can be read: {why}")


def report_refusal(connection: ServerConnection, request: Request, response: Response) -> None:
    """Log a line for a request that is refused, here or by websockets itself."""
    if response.status_code >= HTTPStatus.BAD_REQUEST:
        why = (response.body or b"").decode(errors="replace").strip().partition("\n")[0]
        _log(f"a request is refused, {response.status_code} {response.reason_phrase}: {why}")


def logger() -> logging.Logger:
    """Return what websockets logs to: a line for each of its errors, without a traceback."""
    made = logging.Logger("peg_on_hole_ros.watch", logging.WARNING)
    made.addHandler(_Lines())
    return made


class _Lines(logging.Handler):
    """Prints a record as one line, but for an opening handshake: its refusal has had its own."""

    def emit(self, record: logging.LogRecord) -> None:
        text = record.getMessage()
        if text != "opening handshake failed":
            error = record.exc_info[1] if record.exc_info else None
            _log(f"{text}: {described(error)}" if error else text)


def _log(text):
    line = cut(printable(f"{PROGRAM}: {text}"), _LONGEST_LINE)
    print(line, file=sys.stderr, flush=True)
