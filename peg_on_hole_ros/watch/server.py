"""Gives the page to browsers and frames to pages, on this machine unless told otherwise."""

import asyncio
import json
import os
import signal
import threading
from collections.abc import Callable
from http import HTTPStatus
from urllib.parse import urlsplit

from websockets.asyncio.server import ServerConnection, broadcast, serve
from websockets.datastructures import Headers
from websockets.http11 import Request, Response

from peg_on_hole_ros.errors import PegOnHoleError

PERIOD = 0.05  # [s] between two frames
STREAM = "/stream"
LOOPBACK = ("127.0.0.1", "localhost", "::1")


async def run(
    host: str,
    port: int,
    page: str,
    frame: Callable[[], dict],
    hello: Callable[[], dict],
    ready: Callable[[str], None],
) -> None:
    """
    Serve until cancelled, or until SIGINT or SIGTERM comes to the main thread.

    Parameters
    ----------
    host : str
        Address to listen on.
    port : int
        0: any that is free.
    page : str
        HTML.
    frame : callable
        Returns what all pages are told, every `PERIOD`.
    hello : callable
        Returns what a page is told first; without `status` it is the same for all.
    ready : callable
        Is given the page's address.

    Raises
    ------
    PegOnHoleError
        The address cannot be had.

    """
    pages: set[ServerConnection] = set()

    async def stream(connection: ServerConnection) -> None:
        await connection.send(json.dumps(hello(), allow_nan=False))
        pages.add(connection)
        try:
            await connection.wait_closed()
        finally:
            pages.discard(connection)

    def answer(connection: ServerConnection, request: Request) -> Response | None:
        return _answer(host, page, request)

    try:
        server = await serve(stream, host, port, process_request=answer, max_size=1024)
    except OSError as error:
        raise PegOnHoleError(
            f"--port {port} on {host} cannot be had: {_why(error)}; name another, or 0 for any "
            "that is free"
        ) from None
    _cancelled_by_signals()
    async with server:
        bound = next(iter(server.sockets)).getsockname()[1]
        ready(f"http://{f'[{host}]' if ':' in host else host}:{bound}/")
        clock = asyncio.get_running_loop().time
        due = clock()
        while True:
            broadcast(pages, json.dumps(frame(), allow_nan=False))
            # What took longer is not made up for.
            due = max(due + PERIOD, clock())
            await asyncio.sleep(due - clock())


def _cancelled_by_signals():
    """Let signals cancel this task in its turn: at any moment they would break into asyncio."""
    task = asyncio.current_task()
    if task is None or threading.current_thread() is not threading.main_thread():
        return
    for number in (signal.SIGINT, signal.SIGTERM):
        # In the background of a shell Ctrl-C is for others.
        if signal.getsignal(number) is not signal.SIG_IGN:
            asyncio.get_running_loop().add_signal_handler(number, task.cancel)


def _why(error):
    # asyncio's own error has a sentence of its own around that of the system.
    return os.strerror(error.errno) if error.errno else str(error)


def _answer(host: str, page: str, request: Request) -> Response | None:
    """Return the answer to a request; None: it is the stream."""
    asked = request.headers.get("Host", "")
    name = urlsplit(f"//{asked}").hostname
    if host in LOOPBACK and name not in LOOPBACK:
        # Some other site's name that leads here.
        return _response(HTTPStatus.FORBIDDEN, "text/plain", "not this host")
    path = urlsplit(request.path).path
    if path == STREAM:
        origin = request.headers.get("Origin")
        if origin is not None and urlsplit(origin).netloc != asked:
            return _response(HTTPStatus.FORBIDDEN, "text/plain", "not from another site")
        return None
    if path == "/":
        return _response(HTTPStatus.OK, "text/html; charset=utf-8", page)
    return _response(HTTPStatus.NOT_FOUND, "text/plain", "not here")


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
