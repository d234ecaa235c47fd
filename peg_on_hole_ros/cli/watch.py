"""`peg-on-hole watch`: a live page of a running node, for a cell without RViz."""

import argparse
import asyncio
import re

from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.report.live_page import drawn, live_page

_NAME = re.compile(r"(/[A-Za-z_][A-Za-z0-9_]*)+")


def run(arguments: argparse.Namespace) -> int:
    """Serve the page until Ctrl-C."""
    if not 0 <= arguments.port <= 65535:
        raise PegOnHoleError(f"--port = {arguments.port} is not within 0 to 65535")
    if not _NAME.fullmatch(arguments.node):
        raise PegOnHoleError(
            f"--node = {arguments.node} is not the full name of a node, such as /cell/peg_on_hole"
        )
    server, subscriptions = _needed()
    watched = subscriptions.Watched(arguments.node)

    def hello():
        settings = drawn(watched.configuration or Configuration())
        return {"settings": settings, "frames": list(watched.frames.kept)}

    told = [None]

    def frame():
        made = watched.frame()
        if watched.configuration != told[0]:
            told[0] = watched.configuration
            made["settings"] = drawn(watched.configuration or Configuration())
        return made

    def ready(address):
        print(f"the page of {arguments.node}: {address} (Ctrl-C ends it)", flush=True)

    page = live_page(arguments.node)
    try:
        asyncio.run(server.run(arguments.host, arguments.port, page, frame, hello, ready))
    except KeyboardInterrupt:
        pass
    finally:
        watched.close()
    return 0


def _needed():
    try:
        from peg_on_hole_ros.watch import server, subscriptions
    except ModuleNotFoundError as error:
        name = error.name or ""
        if not name or name.startswith("peg_on_hole_ros"):
            raise
        remedy = (
            "pip install websockets"
            if name.startswith("websockets")
            else "source ROS 2's setup.bash, or install its wheels: pip install '.[ros]'"
        )
        raise PegOnHoleError(f"watch needs {name}: {remedy}") from None
    return server, subscriptions
