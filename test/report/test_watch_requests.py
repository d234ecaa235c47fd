"""What the live page's server does with requests of all kinds, and with clients that stay."""

import asyncio
import os
import signal
import socket
import subprocess
import sys
import threading
import time
from contextlib import ExitStack, suppress

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from cli_helpers import ENDS, IGNORING, ROOT, watching

pytest.importorskip("rclpy")
pytest.importorskip("websockets")

from peg_on_hole_ros.watch import server  # noqa: E402
from tiers import nightly  # noqa: E402

pytestmark = [pytest.mark.xdist_group("dds"), pytest.mark.timeout(300)]

PAGE = ("the page of /peg_on_hole: ", "--port", "0")
APP = ("the topics of /peg_on_hole for Foxglove: ", "--foxglove", "--port", "0")
KEY = "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\nSec-WebSocket-Version: 13\r\n"
UPGRADE = "Connection: Upgrade\r\nUpgrade: websocket\r\n" + KEY


class Served:
    """A server that runs, and what it has logged."""

    def __init__(self, address, log):
        self.port, self._log, self._read = int(address.strip("/").rpartition(":")[2]), log, 0
        self.host = f"127.0.0.1:{self.port}"

    def connect(self):
        return socket.create_connection(("127.0.0.1", self.port), timeout=30)

    def lines(self, least):
        """Return what has been logged since, once there is at least so much."""
        end = time.monotonic() + 30.0
        while len(new := self._log.read_text().splitlines()[self._read :]) < least:
            assert time.monotonic() < end, f"{new}: not {least}"
            time.sleep(0.01)
        self._read += len(new)
        return new

    def ask(self, request):
        """Return status and body of what is answered to bytes; 0 without an answer."""
        with self.connect() as client, suppress(ConnectionError):
            client.sendall(request)
            got = b""
            while (more := client.recv(65536)) and b" 101 " not in got:
                got += more
        head, _, body = got.partition(b"\r\n\r\n")
        return int(head.split()[1]) if head else 0, body.decode(errors="replace")


@pytest.fixture(scope="module")
def served(tmp_path_factory):
    log = tmp_path_factory.mktemp("watch") / "log.txt"
    with log.open("w") as errors, watching(*PAGE, errors=errors) as address:
        found = Served(address, log)
        yield found
        assert found.lines(0) == []


def get(path="/", *headers):
    text = "".join(f"{header}\r\n" for header in headers)
    return f"GET {path} HTTP/1.1\r\n{text}\r\n".encode("latin-1")


def test_what_is_refused_is_a_status_and_a_line(served):
    here = f"Host: {served.host}"
    for request, status, why in (
        (get("/", "Host: [::1"), 400, "Host '[::1' is no name of a host"),
        (get("/", here, here), 400, "2 headers Host, not one"),
        (get("/"), 400, "0 headers Host, not one"),
        (get("/", "Host: evil.example"), 403, "Host 'evil.example' is not this host"),
        (get("/", "Host: localhost@evil"), 400, "Host 'localhost@evil' is no name of a host"),
        (
            get("/stream", here, "Origin: http://a", "Origin: http://a"),
            400,
            "2 headers Origin, not one",
        ),
        (get("/stream", here, "Origin: http://["), 403, "Origin 'http://[' is another site"),
        (
            get("/stream", here, "Origin: http://evil.example", UPGRADE.strip()),
            403,
            "Origin 'http://evil.example' is another site",
        ),
        (get("//[", here), 404, "'//[' is not here"),
        (get("/%2e%2e/%00%ff", here), 404, "'/%2e%2e/%00%ff' is not here"),
        (get("/" + "a" * 300, here), 404, f"'/{'a' * 75}... is not here"),
    ):
        found, body = served.ask(request)
        (line,) = served.lines(1)
        assert (found, body) == (status, why)
        assert line.startswith(f"peg-on-hole: a request is refused, {status} ")
        assert line.endswith(f": {why}")


def test_what_is_asked_for_is_given_and_not_logged(served):
    for host in (served.host, f"localhost:{served.port}", "[::1]:80", "LOCALHOST"):
        status, body = served.ask(get("/?a=%ff", f"Host: {host}", "Origin: http://any"))
        assert status == 200 and body.startswith("<!DOCTYPE html>")
        origin = f"Origin: http://{host}"
        for more in ((), (origin,)):
            request = get("/stream", f"Host: {host}", *more, UPGRADE.strip())
            assert served.ask(request)[0] == 101
    # Browsers connect ahead, and leave.
    served.connect().close()
    assert served.lines(0) == []


@pytest.mark.parametrize(
    "request_",
    [
        b"\x00\xff\r\n\r\n",
        b"GET\r\n\r\n",
        b"GET / HTTP/9.9\r\n\r\n",
        get("/" + "a" * 20_000),
        get("/", "X: " + "a" * 20_000),
        get("/", *["X: y"] * 5000),
        b"GET / HTTP/1.1\r\nHost\r\n\r\n",
        b"GET /\xff HTTP/1.1\r\nHost: localhost\r\n\r\n",
        b"POST / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 5\r\n\r\nabcde",
    ],
)
def test_what_is_no_http_is_a_line(served, request_):
    status, _ = served.ask(request_)
    assert status in (0, 400, 405, 414, 431)
    (line,) = served.lines(1)
    assert line.startswith("peg-on-hole: a request is refused, ") and len(line) <= 300


VALUES = st.text(st.characters(min_codepoint=0x20, max_codepoint=0xFF, exclude_characters="\x7f"
                               + "".join(map(chr, range(0x80, 0xA0)))), max_size=30)  # fmt: skip
HOSTS = st.one_of(
    VALUES, st.sampled_from(["localhost", "[::1]:1", "[::1", "::1", "127.0.0.1:x", "127.0.0.1:-1"])
)
HEADERS = st.one_of(
    st.tuples(st.just("Host"), HOSTS),
    st.tuples(st.just("Origin"), st.one_of(VALUES, HOSTS.map("http://{}".format))),
    st.tuples(
        st.sampled_from(
            ["Connection", "Upgrade", "Sec-WebSocket-Key", "Sec-WebSocket-Version", "Cookie",
             "Sec-WebSocket-Extensions", "Sec-WebSocket-Protocol"]
        ),
        st.one_of(VALUES, st.sampled_from(["Upgrade", "websocket", "13", "permessage-deflate"])),
    ),
)  # fmt: skip
PATHS = st.one_of(
    st.sampled_from(["/", "/stream", "//[", "/stream?", "*", "http://[/"]),
    st.text(st.characters(min_codepoint=0x21, max_codepoint=0x7E), min_size=1, max_size=30),
)


@example("/stream", [("Host", "localhost"), ("Origin", "http://[")])
@given(PATHS, st.lists(HEADERS, max_size=6))
def test_no_request_is_a_fault_of_the_server(served, path, headers):
    status, _ = served.ask(get(path, *(f"{name}: {value}" for name, value in headers)))
    hosts = [value.strip() for name, value in headers if name == "Host"]
    assert status in (101, 200, 400, 403, 404, 426)
    if status in (101, 200):
        assert len(hosts) == 1 and path.partition("?")[0] in ("/", "/stream")
    told = served.lines(0 if status in (101, 200) else 1)
    assert len(told) == (status not in (101, 200)), told
    assert all(line.startswith("peg-on-hole: a request is refused, ") for line in told)


def clinging(connect, path):
    """Yield clients that send nothing, half a request, and a whole one, and read nothing."""
    for sent in (b"", b"GET / HTT", get(path, "Host: 127.0.0.1", UPGRADE.strip())):
        client = connect()
        client.sendall(sent)
        yield client


@pytest.mark.parametrize(
    ("what", "shell"), [(PAGE, IGNORING), (APP, IGNORING), *nightly((PAGE, ()), (APP, ()))]
)
def test_sigint_ends_it_whoever_is_connected_and_whatever_the_shell_ignores(tmp_path, what, shell):
    log = tmp_path / "log.txt"
    with ExitStack() as left, log.open("w") as errors:
        if what is APP:
            pytest.importorskip("foxglove")
        with watching(*what, errors=errors, shell=shell) as address:
            found = Served(address, log)
            for client in clinging(found.connect, "/stream"):
                left.enter_context(client)
    # The app's server logs whose handshake it drops.
    assert what is APP or log.read_text() == ""


def test_it_ends_in_the_background_of_a_script(tmp_path):
    program = f"{sys.executable} -m peg_on_hole_ros.cli.main watch --port 0"
    said = tmp_path / "said"
    said.touch()
    script = f"{program} > {said} & echo $!; wait $!; echo $?"
    shell = subprocess.Popen(
        ["sh", "-c", script],
        stdout=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )
    try:
        pid, end = int(shell.stdout.readline()), time.monotonic() + 60.0
        while not said.read_text():
            assert time.monotonic() < end
            time.sleep(0.02)
        os.kill(pid, signal.SIGINT)
        assert shell.communicate(timeout=60)[0] == "0\n"
    finally:
        with suppress(ProcessLookupError):
            os.kill(pid, signal.SIGKILL)
        shell.kill()
        shell.communicate()


def test_clients_that_do_not_read_do_not_hold_its_end_up():
    """More waits for them than all the buffers of the system take."""
    stopping, address, frames = [], [], [0]

    def frame():
        frames[0] += 1
        return {"long": "x" * 2_000_000}

    served = server.run("127.0.0.1", 0, "", frame, dict, address.append, stopping)
    runs = threading.Thread(target=asyncio.run, args=(served,))
    runs.start()
    end = time.monotonic() + 60.0

    def wait_for(done):
        while not done():
            assert time.monotonic() < end
            time.sleep(0.01)

    wait_for(lambda: address)
    found = Served(address[0], None)
    with ExitStack() as left:
        for _ in range(3):
            for client in clinging(found.connect, "/stream"):
                left.enter_context(client)
        begun = frames[0]
        wait_for(lambda: frames[0] > begun + 10)
        began = time.monotonic()
        stopping.append(signal.SIGINT)
        runs.join(60)
        assert not runs.is_alive() and time.monotonic() - began < ENDS
