"""Late messages of a recording put where they belong, for what cannot go back."""

from collections.abc import Iterable, Iterator
from heapq import heappop, heappush

from peg_on_hole_ros.bags.batch import Item
from peg_on_hole_ros.bags.reader import absolute
from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.engine.tuned import STAMP_ORDER


def in_order(items: Iterable[Item], configuration: Configuration) -> Iterator[Item]:
    """
    Yield every message, one that is late where it belongs.

    As late as the pipeline takes it back to: `filter.late_window`, joint states `joints.delay`
    beside. Nothing is put before a message without a stamp, as a call of reset or tare, or
    before a clock that jumped back.
    """
    joints = absolute(configuration.topics.joint_states)
    delay_ns = round(configuration.joints.delay * 1e9)
    window_ns = round(configuration.filter.late_window * 1e9)
    window_ns += max(delay_ns, 0) if window_ns else 0
    waiting, newest = [], None
    for number, item in enumerate(items):
        # A call of reset or tare has none, nor has what is malformed.
        t_ns = getattr(item.sample, "t_ns", None)
        of_joints = item.topic == joints
        if t_ns is not None and of_joints:
            t_ns -= delay_ns
        if t_ns is None or newest is None or newest - t_ns > STAMP_ORDER.clock_jump_ns + window_ns:
            while waiting:
                yield heappop(waiting)[-1]
            newest = t_ns
        if t_ns is None:
            yield item
            continue
        newest = max(newest, t_ns)
        # Of one stamp, joint states come before the wrench.
        heappush(waiting, (t_ns, not of_joints, number, item))
        while waiting and waiting[0][0] <= newest - window_ns:
            yield heappop(waiting)[-1]
    while waiting:
        yield heappop(waiting)[-1]
