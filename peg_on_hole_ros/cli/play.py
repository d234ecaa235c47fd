"""`peg-on-hole play`: a recording into a running node, as a robot would send it."""

import argparse
import time
from itertools import count

from peg_on_hole_ros.bags.reader import absolute
from peg_on_hole_ros.cli.bag_and_configuration import Reading, open_recording
from peg_on_hole_ros.cli.progress import ProgressBar
from peg_on_hole_ros.cli.without_ros import no_ros
from peg_on_hole_ros.errors import BagDamaged, PegOnHoleError
from peg_on_hole_ros.messages.beside_estimates import STRING
from peg_on_hole_ros.messages.decode import JOINTS_TYPE, WRENCH_TYPE
from peg_on_hole_ros.replay.run import check_bag, sources_of

PLAY_RATES = (0.01, 10.0)
# For a node to come up [s], of which so many pass before it is said that one is waited for.
NODE_PATIENCE, QUIET = 600.0, 1.0
# For the last messages to be taken before the publishers go [s].
_LINGER = 0.5


def run(arguments: argparse.Namespace) -> int:
    """Wait for a node that takes the wrench, and publish to it."""
    least, most = PLAY_RATES
    if not least <= arguments.rate <= most:
        raise PegOnHoleError(f"--rate = {arguments.rate:g} is not within {least:g} to {most:g}")
    bag, configuration, _, _ = open_recording(
        arguments.bag, arguments.config, reading=Reading.of(arguments)
    )
    check_bag(bag, configuration)
    types = dict(zip(sources_of(configuration), (WRENCH_TYPE, JOINTS_TYPE)))
    first_ns, last_ns = bag.span_ns
    seconds = (last_ns - first_ns) * 1e-9
    if not 0.0 <= arguments.start < seconds:
        raise PegOnHoleError(
            f"--start = {arguments.start:g} s is not within the recording: 0 to below "
            f"{seconds:.3g} s"
        )
    described = absolute(configuration.topics.robot_description)
    if (info := bag.topics.get(described)) and info.types == [STRING]:
        types |= {described: STRING}
    publisher, leave = _joined(types)
    try:
        _wait(publisher, absolute(configuration.topics.wrench))
        for turn in count(1):
            begun = time.monotonic()
            published = _play(publisher, bag, arguments.start, arguments.rate)
            took = time.monotonic() - begun
            print(f"played {published} messages of {bag.path} in {took:.1f} s", flush=True)
            if not arguments.loop:
                break
            print(f"round {turn + 1} begins (Ctrl-C ends it)", flush=True)
        time.sleep(_LINGER)
    finally:
        leave()
    if bag.damage:
        raise BagDamaged(bag.damage)
    return 0


def _joined(types):
    """Return publishers in ROS, and what leaves it."""
    try:
        import rclpy
        from rclpy.signals import SignalHandlerOptions

        from peg_on_hole_ros.ros.bag_publisher import BagPublisher
    except ModuleNotFoundError as error:
        raise no_ros(error, "playing") from None
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    node = rclpy.create_node("peg_on_hole_play")

    def leave():
        node.destroy_node()
        rclpy.shutdown()

    return BagPublisher(node, types), leave


def _wait(publisher, wrench):
    """Wait until a node takes the wrench."""
    begun, told = time.monotonic(), False
    while not publisher.listened_to([wrench]):
        waited = time.monotonic() - begun
        if waited > NODE_PATIENCE:
            raise PegOnHoleError(
                f"no node has subscribed to {wrench} within {NODE_PATIENCE:g} s: start "
                "peg-on-hole node with the same topics.wrench and the same ROS_DOMAIN_ID"
            )
        if waited > QUIET and not told:
            told = True
            print(
                f"waiting for a node that subscribes to {wrench}: start peg-on-hole node",
                flush=True,
            )
        time.sleep(0.05)


def _play(publisher, bag, start, rate):
    """Publish from a time of the recording on, at its pace; return how many messages."""
    published, begun = 0, time.monotonic()
    with ProgressBar("playing") as progress:
        for message in publisher.of(bag):
            since = message.offset_ns * 1e-9 - start
            # What comes once and stays is there whatever is left out before it.
            if since < 0.0 and not publisher.stays(message.topic):
                continue
            time.sleep(max(0.0, begun + since / rate - time.monotonic()))
            publisher.publish(message)
            published += 1
            if published % 100 == 0:
                progress(message.share)
    return published
