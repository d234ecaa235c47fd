"""The other side of the node in tests over DDS: publishes its input and collects its output."""

import signal
import subprocess
import sys
import time
from collections import defaultdict
from contextlib import contextmanager

import rclpy
from lifecycle_msgs.srv import ChangeState, GetState
from rcl_interfaces.srv import (
    DescribeParameters,
    GetParameters,
    GetParameterTypes,
    ListParameters,
    SetParameters,
    SetParametersAtomically,
)
from rclpy.experimental import EventsExecutor
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_srvs.srv import Trigger

from peg_on_hole_ros.messages.beside_estimates import DIAGNOSTICS, LATCHED, TOPICS
from peg_on_hole_ros.messages.decode import JOINTS_TYPE, WRENCH_TYPE
from peg_on_hole_ros.messages.ros_messages import message_class

SERVICES = {
    "reset": Trigger,
    "tare": Trigger,
    "payload": Trigger,
    "set_parameters": SetParameters,
    "get_parameters": GetParameters,
    "describe_parameters": DescribeParameters,
    "set_parameters_atomically": SetParametersAtomically,
    "get_parameter_types": GetParameterTypes,
    "list_parameters": ListParameters,
    "change_state": ChangeState,
    "get_state": GetState,
}
PATIENCE = (
    180.0  # [s] until a wait fails; a cold compilation on a busy machine takes a third of it
)


NODE = ("-m", "peg_on_hole_ros.ros.node")


@contextmanager
def node_process(*arguments, program=NODE, shell=()):
    """Start the node, or another program of Python's, with ROS arguments; kill what is left."""
    command = [*shell, sys.executable, *program, "--ros-args", *arguments]
    process = subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    )
    try:
        yield process
    finally:
        if process.poll() is None:
            process.kill()
        process.communicate()


def stop(process) -> str:
    """End the node by SIGINT, expect exit code 0, and return what it printed."""
    process.send_signal(signal.SIGINT)
    text, _ = process.communicate(timeout=PATIENCE)
    assert process.returncode == 0, text
    return text


def wait_until(done, what, executor=None):
    """Wait until a condition holds, and spin if there is what to; fail by name if it does not."""
    end = time.monotonic() + PATIENCE
    while not done():
        assert time.monotonic() < end, f"waited {PATIENCE:g} s in vain: {what}"
        if executor is None:
            time.sleep(0.01)
        else:
            executor.spin_once(timeout_sec=0.02)


class Peer:
    """Publishers of wrench and joint states, and subscriptions to all topics of the node."""

    def __init__(self, node="peg_on_hole"):
        self.context = rclpy.Context()
        rclpy.init(context=self.context)
        self.node = rclpy.create_node("peer", context=self.context)
        self.executor = EventsExecutor(context=self.context)
        self.executor.add_node(self.node)
        self.wrench = self.node.create_publisher(message_class(WRENCH_TYPE), "/wrench", 1000)
        self.joints = self.node.create_publisher(message_class(JOINTS_TYPE), "/joint_states", 1000)
        # A node answers only clients it knows, and it learns of all that is here in this order:
        # once an answer to the last of them or any output has come, it knows them all.
        self.clients = {
            name: self.node.create_client(kind, f"/{node}/{name}")
            for name, kind in SERVICES.items()
        }
        self.received = defaultdict(list)
        self.subscriptions = {}
        for suffix, ros_type in TOPICS.items():
            qos = QoSProfile(depth=5000)
            if suffix in LATCHED:
                qos.durability = DurabilityPolicy.TRANSIENT_LOCAL
            self._subscribe(suffix, ros_type, f"/{node}/{suffix}", qos)
        self._subscribe("/diagnostics", DIAGNOSTICS, "/diagnostics", QoSProfile(depth=100))

    def _subscribe(self, key, ros_type, topic, qos):
        self.subscriptions[key] = self.node.create_subscription(
            message_class(ros_type), topic, self.received[key].append, qos, raw=True
        )

    def spin_until(self, done, what):
        """Spin until a condition holds; fail by name if it does not in time."""
        wait_until(done, what, self.executor)

    def wait_for_matching(self):
        publishers, subscriptions = (self.wrench, self.joints), self.subscriptions.values()
        self.spin_until(
            lambda: (
                all(publisher.get_subscription_count() for publisher in publishers)
                and all(subscription.get_publisher_count() for subscription in subscriptions)
            ),
            "the node to match every topic",
        )
        # This is what the peer knows. That the node knows the clients an answer alone shows.
        self.state()

    def call(self, name, request):
        """Call a service of the node and return its answer."""
        client = self.clients[name]
        self.spin_until(client.service_is_ready, f"service {name}")
        future = client.call_async(request)
        self.spin_until(future.done, f"answer of {name}")
        return future.result()

    def ask(self, name, request):
        """Call a service that changes nothing, again if the first answer is lost; return it."""
        client = self.clients[name]
        self.spin_until(client.service_is_ready, f"service {name}")
        asked, answers = 0.0, []

        def answered():
            nonlocal asked
            if time.monotonic() - asked > 1.0:
                asked = time.monotonic()
                future = client.call_async(request)
                future.add_done_callback(lambda future: answers.append(future.result()))
            return answers

        self.spin_until(answered, f"answer of {name}")
        return answers[0]

    def state(self):
        """Return the node's lifecycle state."""
        return self.ask("get_state", GetState.Request()).current_state.id

    def close(self):
        self.executor.shutdown()
        self.node.destroy_node()
        rclpy.shutdown(context=self.context)
