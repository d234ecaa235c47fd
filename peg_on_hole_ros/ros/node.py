"""The ROS 2 node `peg_on_hole`: a lifecycle node around the message stream that a replay runs."""

import json
import sys
import time
from dataclasses import replace
from functools import partial
from importlib import import_module
from itertools import islice
from traceback import format_exception
from typing import NoReturn

import rclpy
from rclpy.clock import Clock, ClockType
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn
from rclpy.serialization import deserialize_message
from rclpy.subscription import Subscription
from rclpy.timer import Timer
from std_msgs.msg import String
from std_srvs.srv import Trigger

from peg_on_hole_ros.config.configuration import half_stated_zero
from peg_on_hole_ros.config.node_parts import NODE
from peg_on_hole_ros.engine.announced_motion import MODES, NOTHING
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.messages.decode import JOINTS_TYPE, WRENCH_TYPE
from peg_on_hole_ros.messages.ros_messages import message_class, to_ros
from peg_on_hole_ros.messages.stream import (
    EXPECT,
    SET,
    MessageStream,
    is_event,
    message_stream,
)
from peg_on_hole_ros.messages.warm_up import warm
from peg_on_hole_ros.robot.frame_tree import frame_tree
from peg_on_hole_ros.robot.urdf_source import awaited
from peg_on_hole_ros.ros import parameters as node_parameters
from peg_on_hole_ros.ros import process
from peg_on_hole_ros.ros.arrivals_file import ArrivalsFile
from peg_on_hole_ros.ros.diagnostics import Diagnostics
from peg_on_hole_ros.ros.inputs import WaitingMessages, subscribe, take_waiting, why_silent
from peg_on_hole_ros.ros.lifecycle import log_errors
from peg_on_hole_ros.ros.parameter_services import serve_parameters
from peg_on_hole_ros.ros.publishers import Publishers
from peg_on_hole_ros.ros.robot_description import RobotDescription
from peg_on_hole_ros.safe_text import printable, shown
from peg_on_hole_ros.startup.compiling import log_quarters, watched
from peg_on_hole_ros.startup.exit_codes import exit_code
from peg_on_hole_ros.startup.interrupt import ended_by_signals, note_signals

TRACEBACK_PERIOD = 60.0  # [s] between two tracebacks in the log
NO_CLOCK = (
    "use_sim_time is set, but no /clock has come: estimates go on by the stamps of the messages, "
    "their latency is unknown"
)
# A sensor that has been silent for so long, by this machine's clock, is not tared.
SILENT_NS = 1_000_000_000
SILENT = "no wrench has come for a second, the sensor may carry something else by now"
SUCCESS = TransitionCallbackReturn.SUCCESS


class PegOnHoleNode(node_parameters.FilesChecked, node_parameters.ExplainsRefusals, LifecycleNode):  # type: ignore[misc]
    """
    Takes wrench and joint states, publishes everything that each wrench makes known.

    Parameters
    ----------
    arguments : list of str
        Of the process: the parameters files among them are looked through.

    Raises
    ------
    PegOnHoleError
        Parameters that cannot be used, and a parameters file for another node's name.

    """

    def __init__(self, arguments: list[str]) -> None:
        self.arguments = arguments
        self._stream: MessageStream | None = None
        self._declared = self._finalized = False
        super().__init__(
            NODE,
            automatically_declare_parameters_from_overrides=True,
            start_parameter_services=False,
        )
        serve_parameters(self)
        self._recording: ArrivalsFile | None = None
        self._outputs: Publishers | None = None
        self.arrivals = WaitingMessages()
        self._while_active: list = []
        self._timer: Timer | None = None
        self._clock_missed = False
        # When the last wrench came; none has.
        self._heard_ns = sys.maxsize
        self._services_made: list = []
        self._description: RobotDescription | None = None
        self._expecting: Subscription | None = None
        node_parameters.declare(self)
        self.configuration, self.options = node_parameters.read(self)
        node_parameters.describe(self)
        self.add_post_set_parameters_callback(self._take_parameters)
        self._declared = True

    @log_errors
    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Build the estimator from the parameters and have everything compiled."""
        self.configuration, self.options = node_parameters.read(self)
        self._warn(filter(None, [half_stated_zero(self.configuration)]))
        begun = time.perf_counter()
        with watched(log_quarters(self.get_logger().info)):  # type: ignore[arg-type]
            warm(self.configuration, to_ros)
        # What the first alarm plans with.
        import_module("scipy.special")
        self.get_logger().info(f"kernel ready after {time.perf_counter() - begun:.1f} s")
        self._stream = message_stream(self.configuration, self.options.markers_rate)
        self.arrivals = WaitingMessages(self.options.qos_depth, self._stream.pushed_out)
        self._recording = ArrivalsFile(self, self.configuration, self.options)
        self._outputs = Publishers(self, self.options.qos_depth)
        self._look_for_frames()
        if awaited(self.configuration.joints):
            self._description = RobotDescription(self, self.configuration, self._describe)
        self._expecting = self.create_subscription(String, "~/expect", self._expect, 10)
        for name in ("reset", "tare", "payload"):
            service = self.create_service(Trigger, f"~/{name}", self._service(name))
            self._services_made.append(service)
        return super().on_configure(state)

    @log_errors
    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Begin to listen."""
        topics = self.configuration.topics
        wrench = self.resolve_topic_name(topics.wrench)
        # A second activation goes on with the counts of the first.
        counts = self._stream.counts
        published = self.resolve_topic_name("~/state")
        self._diagnostics = Diagnostics(
            lambda: self.count_publishers(wrench),
            lambda: self.count_publishers(published),
            counts,
            partial(why_silent, self, topics),
            self.get_fully_qualified_name().strip("/"),
        )
        self._reported_ns = time.monotonic_ns()
        inputs = (
            ("wrench", WRENCH_TYPE, topics.wrench, self.arrivals.wrench),
            ("joints", JOINTS_TYPE, topics.joint_states, self.arrivals.joints),
        )
        # The ROS clock may be a simulator's that stands still.
        clock = Clock(clock_type=ClockType.STEADY_TIME)
        self._timer = self.create_timer(1.0, self._report, clock=clock)
        for source, ros_type, topic, take in inputs:
            kind, missing = message_class(ros_type), partial(self._stream.missing, source)
            subscription = subscribe(self, kind, topic, self.options.qos_depth, take, missing)
            self._while_active.append(subscription)
        self.get_logger().info(
            f"active: listening to {wrench} and {self.resolve_topic_name(topics.joint_states)}"
        )
        self._place()
        return super().on_activate(state)

    @log_errors
    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Stop listening; the estimate is kept, a gap in the stamps is bridged."""
        self._stop_listening()
        return super().on_deactivate(state)

    @log_errors
    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Finish record and try, forget the estimate."""
        self._release()
        return SUCCESS

    @log_errors
    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Finish record and try."""
        self._release()
        self._finalized = True
        return SUCCESS

    @log_errors
    def on_error(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Let go of what a transition that failed has left, so that the node can be configured."""
        # Where that fails as well, the node is finalized.
        self._finalized = True
        self._release()
        self._finalized = False
        return SUCCESS

    @property
    def is_configured(self) -> bool:
        """Whether the estimator has been built from the parameters."""
        return self._stream is not None

    @property
    def is_declared(self) -> bool:
        """Whether all parameters have their first values."""
        return self._declared

    @property
    def is_finalized(self) -> bool:
        """Whether the node cannot be configured any more."""
        return self._finalized

    def _take_parameters(self, changed):
        values = node_parameters.live(changed)
        if values and self.is_configured:
            # A replay of what arrived takes it at the same place.
            event = SET + json.dumps(values)
            answer = self._stream.on_event(event)
            if not answer.success:
                raise PegOnHoleError(answer.message)
            self._recording.event(event)
            self.get_logger().info(printable(answer.message))

    def _describe(self, text):
        self._stream.use_robot_description(text)
        joints = replace(self.configuration.joints, description=text)
        self.configuration = replace(self.configuration, joints=joints)
        self._recording.describe(self.configuration)
        self._look_for_frames()
        if self._while_active:
            self._place()

    def _look_for_frames(self):
        self._tree = frame_tree(self.configuration)
        self._warn(filter(None, [self._tree.hole_line, self._tree.peg_line]))

    def _place(self):
        self._outputs.place(self._tree, self.get_clock().now().nanoseconds)

    @property
    def _waiting(self):
        """What no message is used for want of; empty: nothing."""
        return self._description.waiting if self._description else ""

    def close(self) -> None:
        """Work off what waits, finish the record and tell a try under way, in whatever state."""
        self._stop_listening()
        if self._recording is not None:
            self._recording.close()
        if self._stream is not None:
            ended = self._stream.finish()
            self._outputs.publish_last(ended)
            self._log_cycles(ended)

    def _stop_listening(self):
        try:
            self.process()
        finally:
            for subscription in self._while_active:
                self.destroy_subscription(subscription)
            self._while_active = []
            if self._timer is not None:
                self.destroy_timer(self._timer)
                self._timer = None
                self._warn(self._diagnostics.rest(self._stream.counts))

    def _release(self):
        try:
            self.close()
        finally:
            for service in self._services_made:
                self.destroy_service(service)
            if self._expecting is not None:
                self.destroy_subscription(self._expecting)
            for made in (self._description, self._outputs):
                if made is not None:
                    made.destroy()
            self._description = self._expecting = None
            self._services_made, self._outputs, self._stream = [], None, None

    def take_waiting(self) -> int:
        """Take what has come and waits in DDS; return how many messages that were."""
        return sum(take_waiting(subscription) for subscription in self._while_active)

    def process(self, most: int | None = None) -> None:
        """Work off what has arrived, or so many, the sources merged by their stamps."""
        for source, payload in islice(self.arrivals.take(), most):
            if self._while_active:
                try:
                    (self._on_wrench if source == "wrench" else self._on_joints)(payload)
                except Exception as error:
                    self._failed(source, error)

    def _on_wrench(self, payload):
        begun = time.monotonic_ns()
        self._heard_ns = begun
        if self._waiting:
            # No part of a record either: a replay of it has the description from the start.
            self._stream.undescribed("wrench")
            return self._diagnostics.received("wrench", 0)
        self._recording.wrench(payload)
        published = self._stream.take_wrench_bytes(payload, self._read_wrench)
        if published is not None:
            self._outputs.publish(published)
            self._log_cycles(published.beside)
            now_ns = self.get_clock().now().nanoseconds
            self._diagnostics.aged(now_ns - self._stream.t_ns if now_ns else None)
        self._diagnostics.received("wrench", time.monotonic_ns() - begun, published is not None)

    def _read_wrench(self, payload):
        message = self._deserialised("wrench", WRENCH_TYPE, payload)
        if self._stream.frame is None and message is not None:
            known, line = self._stream.take_frame(message.header.frame_id)
            if line:
                tell = self.get_logger().info if known else self.get_logger().warning
                tell(printable(line))
        return message

    def _on_joints(self, payload):
        begun = time.monotonic_ns()
        if self._waiting:
            self._stream.undescribed("joints")
            return self._diagnostics.received("joints", 0)
        self._recording.joints(payload)
        self._stream.take_joints_bytes(payload, self._read_joints)
        self._diagnostics.received("joints", time.monotonic_ns() - begun)

    def _read_joints(self, payload):
        return self._deserialised("joints", JOINTS_TYPE, payload)

    def _failed(self, what, error):
        """Count and log an error of the program, and begin anew: a cell needs its monitor."""
        self._stream.failed(what)
        self._log_error(what, error, "the filter is restarted")
        # Nobody knows where the error left the filter, or what it had learnt by then.
        self._recording.event("reset")
        self._stream.on_event("reset")

    def _log_error(self, what, error, then):
        text = "".join(format_exception(error))
        self.get_logger().error(
            f"an error of the program at {what}: {error!r}; {then}\n{text}",
            throttle_duration_sec=TRACEBACK_PERIOD,
        )

    def _log_cycles(self, messages):
        for suffix, _, fields in messages:
            if suffix == "cycle":
                self.get_logger().info(f"cycle: {fields['data']}")

    def _deserialised(self, source, ros_type, payload):
        try:
            return deserialize_message(payload, message_class(ros_type))
        except Exception:  # rmw's own error type, which has no public name
            self._stream.unreadable(source)
            return None

    def _service(self, name):
        def respond(_, response):
            if not self._while_active:
                response.success, response.message = False, "the node is not active"
                return response
            if name != "reset" and time.monotonic_ns() - self._heard_ns > SILENT_NS:
                # No part of what has arrived: a replay, which has stamps only, would take it.
                answer = self._stream.pipeline.refuse_tare(SILENT)
                response.success, response.message = answer
                return response
            self._recording.event(name)
            try:
                response.success, response.message = self._stream.on_event(name)
            except Exception as error:
                self._failed(name, error)
                response.success = False
                response.message = f"an error of the program: {error!r}; the filter was restarted"
            self.get_logger().info(f"{name}: {response.message}")
            return response

        return respond

    def _expect(self, message):
        event = EXPECT + message.data
        if not is_event(event):
            known = ", ".join((*MODES, NOTHING))
            self._warn([f"~/expect: {shown(message.data)} is not one of {known}"])
            return
        self._recording.event(event)
        self.get_logger().info(self._stream.on_event(event).message)

    def _report(self):
        try:
            self._publish_diagnostics()
        except Exception as error:
            self._log_error("the diagnostics", error, "the next report is in a second")

    def _publish_diagnostics(self):
        now_ns = time.monotonic_ns()
        elapsed_ns, self._reported_ns = max(1, now_ns - self._reported_ns), now_ns
        stamp_ns = self.get_clock().now().nanoseconds
        pipeline = self._stream.pipeline
        fields, lines = self._diagnostics.report(
            stamp_ns or self._stream.t_ns or 0,
            elapsed_ns,
            self._stream.counts,
            pipeline.health,
            pipeline.left_out,
            pipeline.causes,
            self._waiting or self._stream.refused,
            self._stream.failed_looks,
        )
        self._warn(lines)
        if not stamp_ns and not self._clock_missed:
            self._warn([NO_CLOCK])
        # Told again only after a clock that has come is gone.
        self._clock_missed = not stamp_ns
        self._outputs.diagnostics(fields)

    def _warn(self, lines):
        for line in lines:
            self.get_logger().warning(printable(line))


def main(arguments: list[str] | None = None) -> NoReturn:
    """
    Run the node until it is stopped, and end the process: by 0, or 2 where it cannot start.

    Parameters
    ----------
    arguments : list of str, optional
        All of them for ROS; without, those of the process.

    """
    process.leave(exit_code(lambda: _run(sys.argv[1:] if arguments is None else arguments)))


@ended_by_signals()
def _run(arguments):
    node = None
    try:
        process.init(arguments)
        node = PegOnHoleNode(arguments)
        if node.options.autostart and node.trigger_configure() != SUCCESS:
            return 2
        stopping = note_signals()
        if node.options.autostart and node.trigger_activate() != SUCCESS:
            return 2
        process.spin(node, stopping)
    finally:
        try:
            if node is not None:
                node.close()
                node.destroy_node()
        finally:
            rclpy.try_shutdown()
    return 0


if __name__ == "__main__":
    main()
