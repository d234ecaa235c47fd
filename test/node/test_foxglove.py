"""`watch --foxglove`: a real node, the real command, and a client of the app's protocol."""

import json
import socket
import struct
import threading
from contextlib import ExitStack

import pytest

from cli_helpers import ROOT, command, watching
from dds_peer import node_process

rclpy = pytest.importorskip("rclpy")
pytest.importorskip("foxglove")
pytest.importorskip("websockets")

from websockets.exceptions import ConnectionClosed  # noqa: E402
from websockets.sync.client import connect  # noqa: E402

from peg_on_hole_ros.bags.reader import Bag  # noqa: E402
from peg_on_hole_ros.messages.beside_estimates import LATCHED, PREFIX, TOPICS  # noqa: E402
from peg_on_hole_ros.messages.definitions import definition  # noqa: E402
from peg_on_hole_ros.ros.player import Player  # noqa: E402

pytestmark = [pytest.mark.xdist_group("dds"), pytest.mark.timeout(600)]
BAG = ROOT / "bags" / "closing_with_slip.mcap"


def served():
    return watching("the topics of /peg_on_hole for Foxglove: ", "--foxglove", "--port", "0")


class App:
    """What an app does: look at topics, and keep what comes of each."""

    def __init__(self, address, *topics):
        # The protocol's name as the SDK's documentation gives it.
        self._open = ExitStack()
        self._socket = self._open.enter_context(
            connect(address, subprotocols=["foxglove.sdk.v1"], max_size=None)
        )
        self.channels = {}
        while not self.channels:
            said = self._socket.recv(timeout=60)
            if isinstance(said, str) and json.loads(said)["op"] == "advertise":
                self.channels = {c["topic"]: c for c in json.loads(said)["channels"]}
        self.came = {topic: [] for topic in topics}
        self._some = threading.Condition()
        asked = [{"id": i, "channelId": self.channels[t]["id"]} for i, t in enumerate(topics)]
        self._socket.send(json.dumps({"op": "subscribe", "subscriptions": asked}))
        self._topics = topics
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self):
        try:
            for said in self._socket:
                if isinstance(said, bytes) and said[0] == 1:
                    number = struct.unpack_from("<I", said, 1)[0]
                    with self._some:
                        self.came[self._topics[number]].append(said[13:])
                        self._some.notify_all()
        except ConnectionClosed:
            pass

    def wait_for(self, topic, payload):
        with self._some:
            assert self._some.wait_for(lambda: payload in self.came[topic], timeout=60), topic

    def close(self):
        self._open.close()
        self._reader.join(60)


@pytest.mark.nightly
def test_what_is_looked_at_comes_byte_for_byte_and_the_rest_is_not_taken():
    state, mode = PREFIX + "state", PREFIX + "contact_mode"
    with served() as address, node_process() as process:
        player = Player("/wrench", "/joint_states", process)
        asking = rclpy.create_node("asking")
        app = App(address, state, mode)
        try:
            assert address.startswith("ws://127.0.0.1:")
            assert set(app.channels) == {PREFIX + t for t in TOPICS} | {"/diagnostics"}
            assert app.channels[state]["encoding"] == "cdr"
            assert app.channels[state]["schemaEncoding"] == "ros2msg"
            assert app.channels[state]["schema"] == definition("sensor_msgs/msg/JointState")
            player.wait_for_node()
            player.play(Bag(BAG), 1.0)
            published = {
                topic: [payload for name, _, _, payload in player.received if name == topic]
                for topic in (state, mode)
            }
            # The last one said: all before it has come, or was dropped.
            app.wait_for(state, published[state][-1])
            app.wait_for(mode, published[mode][-1])
            assert set(app.came[state]) <= set(published[state])
            assert len(app.came[state]) > 0.9 * len(published[state])
            # The player alone, and nobody for the app.
            assert asking.count_subscribers(PREFIX + "contacts") == 1
            assert asking.count_subscribers(state) == 2
            # What is published on change is told to whoever comes late, while others look.
            late = App(address, *(PREFIX + topic for topic in LATCHED))
            late.wait_for(mode, published[mode][-1])
            late.close()
        finally:
            app.close()
            asking.destroy_node()
            player.close()


def test_a_port_that_is_taken_is_said_in_a_line():
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        done = command("watch", "--foxglove", "--port", port)
    assert done.returncode == 2
    assert done.stderr.splitlines() == [
        f"peg-on-hole: error: --port {port} on 127.0.0.1 cannot be had: Address already in use; "
        "name another, or 0 for any that is free"
    ]
