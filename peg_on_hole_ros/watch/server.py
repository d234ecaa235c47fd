"""Gives the page to browsers and frames to pages, on this machine unless told otherwise."""

import asyncio
import json
import os
from collections.abc import Callable, Sequence
from typing import Any
from weakref import WeakSet

from websockets.asyncio.server import ServerConnection, broadcast, serve
from websockets.exceptions import ConnectionClosed
from websockets.http11 import Request, Response

from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.watch.requests import Connection, answer, logger, report_refusal

FRAME_PERIOD = 0.05  # [s] between two frames
# From the end of the frames until connections are cut whose other side does not close them [s].
CUT_AFTER = 0.5


async def run(
    host: str,
    port: int,
    page: str,
    frame: Callable[[], dict],
    hello: Callable[[], dict],
    ready: Callable[[str], None],
    stopping: Sequence[int],
) -> None:
    """
    Serve until stopped, and end within some `CUT_AFTER`, whatever the browsers do.

    Parameters
    ----------
    host : str
        Address to listen on.
    port : int
        0: any that is free.
    page : str
        HTML.
    frame : callable
        Returns what all pages are told, every `FRAME_PERIOD`.
    hello : callable
        Returns what a page is told first; without `status` it is the same for all.
    ready : callable
        Is given the page's address.
    stopping : sequence of int
        Of `note_signals`; is looked at every `FRAME_PERIOD`.

    Raises
    ------
    PegOnHoleError
        The address cannot be had.

    """
    pages: set[ServerConnection] = set()
    connections: WeakSet[ServerConnection] = WeakSet()

    def connected(*arguments: Any, **options: Any) -> Connection:
        connection = Connection(*arguments, **options)
        connections.add(connection)
        return connection

    async def stream(connection: ServerConnection) -> None:
        try:
            await connection.send(json.dumps(hello(), allow_nan=False))
            pages.add(connection)
            await connection.wait_closed()
        except ConnectionClosed:
            pass
        finally:
            pages.discard(connection)

    def answered(connection: ServerConnection, request: Request) -> Response | None:
        return answer(host, page, request)

    try:
        server = await serve(
            stream, host, port, process_request=answered, process_response=report_refusal,
            create_connection=connected, max_size=1024, logger=logger(),  # type: ignore[arg-type]
        )  # fmt: skip
    except OSError as error:
        raise PegOnHoleError(
            f"--port {port} on {host} cannot be had: {_why(error)}; name another, or 0 for any "
            "that is free"
        ) from None
    bound = next(iter(server.sockets)).getsockname()[1]
    ready(f"http://{f'[{host}]' if ':' in host else host}:{bound}/")
    clock = asyncio.get_running_loop().time
    due = clock()
    try:
        while not stopping:
            broadcast(pages, json.dumps(frame(), allow_nan=False))
            # What took longer is not made up for.
            due = max(due + FRAME_PERIOD, clock())
            await asyncio.sleep(due - clock())
    finally:
        server.close()
        await asyncio.wait([asyncio.ensure_future(server.wait_closed())], timeout=CUT_AFTER)
        # What is left does not read, or has not yet sent a whole request.
        for connection in connections:
            connection.transport.abort()
        await server.wait_closed()


def _why(error):
    # asyncio's own error has a sentence of its own around that of the system.
    return os.strerror(error.errno) if error.errno else str(error)
