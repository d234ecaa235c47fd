"""`peg-on-hole watch`: a running node on a live page or in the Foxglove app, without RViz."""

import argparse
import asyncio
import re
import socket
from contextlib import suppress
from importlib import import_module

from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.report.live_page import drawn, live_page
from peg_on_hole_ros.safe_text import shown
from peg_on_hole_ros.startup.interrupt import note_signals

PAGE_PORT = 8470
# Where the app looks unless told otherwise.
FOXGLOVE_PORT = 8765
_INSTALL_COMMANDS = {
    "websockets": "pip install websockets",
    "foxglove": "pip install foxglove-sdk",
}
_NODE_NAME = re.compile(r"(/[A-Za-z_][A-Za-z0-9_]*)+")


def run(arguments: argparse.Namespace) -> int:
    """Serve the page until Ctrl-C."""
    port = arguments.port
    if port is None:
        port = FOXGLOVE_PORT if arguments.foxglove else PAGE_PORT
    if not 0 <= port <= 65535:
        raise PegOnHoleError(f"--port = {port} is not within 0 to 65535")
    if not _NODE_NAME.fullmatch(arguments.node):
        raise PegOnHoleError(
            f"--node = {arguments.node} is not the full name of a node, such as /cell/peg_on_hole"
        )
    _check_host(arguments.host)
    with suppress(KeyboardInterrupt):  # before it serves
        (_foxglove if arguments.foxglove else _page)(arguments.node, arguments.host, port)
    return 0


def _check_host(host):
    """Refuse what is no address of this machine; a server would blame the port."""
    try:
        found = socket.getaddrinfo(host or None, 0, type=socket.SOCK_STREAM)
        for family, kind, protocol, _, address in found:
            with socket.socket(family, kind, protocol) as one:
                one.bind(address)
    except (OSError, ValueError) as error:  # ValueError: what is no name at all
        why = getattr(error, "strerror", None) or error
        raise PegOnHoleError(
            f"--host {shown(host)} is no address of this machine: {why}; name one, such as "
            "127.0.0.1 for this machine alone, or 0.0.0.0 for all that reach it"
        ) from None


def _foxglove(node, host, port):
    app = _needed("foxglove_app")

    def ready(address):
        print(f"the topics of {node} for Foxglove: {address} (Ctrl-C ends it)", flush=True)

    app.run(node, host, port, ready, note_signals())


def _page(node, host, port):
    server, subscriptions = _needed("server"), _needed("subscriptions")
    watched = subscriptions.WatchedNode(node)

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
        print(f"the page of {node}: {address} (Ctrl-C ends it)", flush=True)

    page = live_page(node)
    try:
        asyncio.run(server.run(host, port, page, frame, hello, ready, note_signals()))
    finally:
        watched.close()


def _needed(module):
    try:
        return import_module(f"peg_on_hole_ros.watch.{module}")
    except ModuleNotFoundError as error:
        name = error.name or ""
        if not name or name.startswith("peg_on_hole_ros"):
            raise
        remedy = _INSTALL_COMMANDS.get(
            name.split(".")[0],
            "source ROS 2's setup.bash, or install its wheels: pip install '.[ros]'",
        )
        raise PegOnHoleError(f"watch needs {name}: {remedy}") from None
