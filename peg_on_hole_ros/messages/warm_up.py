"""Everything compiled and imported before the first message, so that none waits for it."""

from collections.abc import Callable
from dataclasses import replace

from peg_on_hole_ros.config.options import Configuration, JointInput
from peg_on_hole_ros.messages.cdr import Encoder
from peg_on_hole_ros.messages.decode import JOINTS_TYPE, WRENCH_TYPE
from peg_on_hole_ros.messages.plain import header
from peg_on_hole_ros.messages.stream import message_stream
from peg_on_hole_ros.records import ANGLES

# Samples.
REST_SAMPLES = 60


def warm(configuration: Configuration, convert: Callable = lambda _, fields: fields) -> None:
    """
    Run a made-up closing motion through a stream of its own, so that all is compiled and imported.

    Parameters
    ----------
    configuration : Configuration
        With the peg's own joints in place of a robot's, as no robot stands in contact here.
    convert : callable
        From (type, fields) to what the stream is given and what is made of its output: the node's
        is to ROS messages.

    """
    joints = JointInput(hole_tilt_stddev=configuration.joints.hole_tilt_stddev)
    configuration = replace(configuration, joints=joints)
    stream = message_stream(configuration)
    scene = configuration.scene
    encode = Encoder(WRENCH_TYPE)
    zero = {"x": 0.0, "y": 0.0, "z": 0.0}
    # Slip in all directions, long enough for a contact mode to be declared, a rest, then on to two
    # points.
    declared = 20 + round(2e3 * configuration.monitor.mode_dwell)
    count = 180 + declared
    for n in range(count + REST_SAMPLES):
        t_ns = 1_000_000_000 + n * 1_000_000
        k = n - min(max(n - declared, 0), REST_SAMPLES)
        gamma = scene.gamma0 * (1.5 - 0.6 * k / count)
        if k % 8 == 0:
            # Now and then a surprise, which has code of its own.
            gamma += 6 * configuration.joints.position_stddev
        position = {"name": list(ANGLES), "position": [gamma, 1e-3 * k, 2e-3 * k]}
        wrench = {"header": header(t_ns), "wrench": {"force": zero, "torque": zero}}
        stream.on_joints(convert(JOINTS_TYPE, {"header": header(t_ns), **position}))
        message = convert(WRENCH_TYPE, wrench)
        if k % 2:
            stream.take_wrench_bytes(encode(wrench), _giving(message))
            continue
        for _, ros_type, fields in stream.on_wrench(message):
            convert(ros_type, fields)
    # What reports say has compiled code too, which would hold up the first second of wrenches.
    _ = stream.pipeline.health, stream.pipeline.causes


def _giving(message):
    return lambda payload: message
