"""Run a bag through the stream that the node runs, message by message in the bag's order."""

import json
import time
from collections import Counter
from collections.abc import Callable, Iterable
from typing import NamedTuple, Protocol

from peg_on_hole_ros.configuration import from_parameters, node_options, uncertain_offsets
from peg_on_hole_ros.edges.advice import Seen, remedy
from peg_on_hole_ros.edges.bags.arrival_record import EVENT_TOPIC
from peg_on_hole_ros.edges.bags.reader import Bag, BagMessage, absolute
from peg_on_hole_ros.edges.bags.writer import CONFIGURATION_METADATA
from peg_on_hole_ros.edges.contact_steps import ContactSteps
from peg_on_hole_ros.edges.messages.decode import JOINTS_TYPE, WRENCH_TYPE
from peg_on_hole_ros.edges.messages.output import STRING, Message, smoothed_messages
from peg_on_hole_ros.edges.messages.stream import MessageStream, message_stream, orientation_of
from peg_on_hole_ros.edges.warm_up import warm
from peg_on_hole_ros.errors import BagError, PegOnHoleError
from peg_on_hole_ros.estimation.filters.methods import make_filter
from peg_on_hole_ros.estimation.filters.smoother import SmoothingFilter
from peg_on_hole_ros.options import Configuration, NodeOptions

_REMEDY = "name the topics in the configuration (topics.wrench, topics.joint_states)"


class Sink(Protocol):
    """Takes what a replay gives."""

    def add(self, t_ns: int, messages: list[Message]) -> None:
        """Take the messages of one stamp [ns]."""


class Replayed(NamedTuple):
    """
    What became of the messages of a bag.

    Attributes
    ----------
    read : int
        Wrenches and joint states in the bag.
    used : int
        Those that the estimate rests on.
    dropped : dict of str to int
        All others by reason.
    events : dict of str to int
        What else was counted: late but used, restarts, gaps, ...
    seconds : float
        Of the wall clock, without compiling [s].
    contact_steps : ContactSteps
        How many steps on three contacts were believed.
    by_source : dict of str to int
        Messages in the bag of `wrench` and `joints`.
    seen : Seen
        What they had.

    """

    read: int
    used: int
    dropped: dict[str, int]
    events: dict[str, int]
    seconds: float
    contact_steps: ContactSteps
    by_source: dict[str, int]
    seen: Seen


def check_bag(bag: Bag, configuration: Configuration) -> dict[str, str]:
    """Return the topics that a replay reads with their types, or raise BagError."""
    topics = configuration.topics
    needed = {absolute(topics.wrench): WRENCH_TYPE, absolute(topics.joint_states): JOINTS_TYPE}
    bag.require(needed, _REMEDY)
    events = bag.topics.get(EVENT_TOPIC)
    return needed | ({EVENT_TOPIC: STRING} if events and events.types == [STRING] else {})


def stored_configuration(bag: Bag) -> Configuration | None:
    """
    Return the configuration that a bag carries, or None.

    Raises
    ------
    PegOnHoleError
        It is not one of this version.

    """
    return _of_stored(bag, from_parameters)


def stored_options(bag: Bag) -> NodeOptions | None:
    """
    Return what a bag says of the outputs beyond the estimate, or None where it carries nothing.

    That is the rate of the markers, which a record of arrivals has; the rest are defaults.

    Raises
    ------
    PegOnHoleError
        It is not one of this version.

    """
    return _of_stored(bag, node_options)


def _of_stored(bag, take):
    stored = bag.metadata.get(CONFIGURATION_METADATA)
    if stored is None:
        return None
    try:
        return take({name: json.loads(value) for name, value in stored.items()})
    except (PegOnHoleError, ValueError) as error:
        raise PegOnHoleError(
            f"the configuration in {bag.path} cannot be used ({error}); give one with --config"
        ) from None


def replay_bag(
    bag: Bag,
    configuration: Configuration,
    markers_rate: float,
    sinks: Iterable[Sink],
    progress: Callable[[float], None] | None = None,
    smoothed: Sink | None = None,
    watch: Callable[[str, object], None] | None = None,
) -> Replayed:
    """
    Replay a bag.

    Parameters
    ----------
    bag : Bag
    configuration : Configuration
    markers_rate : float
        [Hz] of stamp time.
    sinks : iterable of Sink
        Each is given all output, in order.
    progress : callable, optional
        Called with the share that is done.
    smoothed : Sink, optional
        Is given the smoothed state of every stamp, after all other output.
    watch : callable, optional
        Called with `wrench` or `joints` and each message before it is used.

    Raises
    ------
    BagError
        A needed topic is missing or of another type, no message could be used, or no joint state
        is of a time of the wrench's.
    PegOnHoleError
        Smoothing is asked for with another filter than the extended one, or with an uncertain
        bias or hole tilt.

    """
    if smoothed and configuration.filter.method != "extended":
        raise PegOnHoleError(
            f"filter.method = {configuration.filter.method!r} cannot be smoothed; the smoother "
            "works on 'extended'"
        )
    if smoothed:
        for name, value in uncertain_offsets(configuration):
            raise PegOnHoleError(
                f"{name} = {value:g} cannot be smoothed: the smoother carries neither bias nor "
                "tilt; set it to 0.0 and state what `calibrate` finds, or leave out --smooth"
            )
    needed = check_bag(bag, configuration)
    wrench_topic, joints_topic = list(needed)[:2]
    total = sum(bag.topics[topic].count for topic in needed)
    sinks = list(sinks)
    # A URDF that cannot be used is refused before the long work of compiling.
    orientation_of(configuration.joints)
    warm(configuration)
    make = SmoothingFilter if smoothed else make_filter
    steps, seen = ContactSteps(), Seen(configuration.joints.names)
    stream = message_stream(configuration, markers_rate, steps.watched(make))
    unreadable = Counter(bag.undecodable)
    begun = time.perf_counter()
    for count, item in enumerate(bag.messages(needed)):
        source = {wrench_topic: "wrench", joints_topic: "joints"}.get(item.topic)
        if source:
            seen.add(source, item.message)
            if watch:
                watch(source, item.message)
        messages = hand_over(stream, item, needed)
        if messages:
            for sink in sinks:
                sink.add(stream.t_ns, messages)
        if progress and count % 256 == 0:
            progress(count / total)
    if smoothed:
        for t_ns, state, covariance in zip(*stream.pipeline.filter.smooth()):
            smoothed.add(t_ns, smoothed_messages(t_ns, state, covariance))
    seconds = time.perf_counter() - begun
    for topic, source in ((wrench_topic, "wrench"), (joints_topic, "joints")):
        for _ in range(bag.undecodable[topic] - unreadable[topic]):
            stream.unreadable(source)
    read = {"wrench": bag.topics[wrench_topic].count, "joints": bag.topics[joints_topic].count}
    apart = seen.apart(configuration)
    if apart:
        raise BagError(f"{bag.path}: {apart}")
    used, dropped, events = _fates(stream.counts, read)
    if not stream.counts.get("wrench_used"):
        reasons = ", ".join(f"{reason} {n}" for reason, n in dropped.items())
        raise BagError(
            f"{bag.path}: no wrench of {read['wrench']} could be used: {reasons}; "
            f"{remedy(dropped, configuration.joints.names, seen)}"
        )
    total = sum(read.values())
    return Replayed(total, used, dropped, events, seconds, steps, read, seen)


def hand_over(stream: MessageStream, item: BagMessage, needed: Iterable[str]) -> list[Message]:
    """
    Hand a message of a bag to a stream as the node has it; return what it makes known.

    `needed` are the topics that `check_bag` returns, in their order.
    """
    wrench_topic, joints_topic = list(needed)[:2]
    if item.topic == wrench_topic:
        return stream.on_wrench(item.message)
    if item.topic == joints_topic:
        stream.on_joints(item.message)
    # A name that this version does not know changes nothing that it could repeat.
    elif item.message.data in ("reset", "tare"):
        stream.on_event(item.message.data)
    return []


def _fates(counts, read):
    """Return how many messages were used, and those dropped and other events, by reason."""
    dropped, events = {}, {}
    for name, count in sorted(counts.items()):
        if not count or name in ("wrench_used", "joints_used"):
            continue
        fate = "_dropped_" in name or name == "joints_gated"
        (dropped if fate else events)[name] = count
    used = {source: counts.get(f"{source}_used", 0) for source in read}
    for source, count in read.items():
        lost = sum(n for name, n in dropped.items() if name.startswith(source))
        # What is ahead, and what was late, waits for the next wrench; at the end some for ever.
        waiting = count - used[source] - lost
        if waiting > 0:
            dropped[f"{source}_dropped_after_last_wrench"] = waiting
        if waiting > 0 and source == "wrench":
            # These were late, all of them, and were not used.
            events["wrench_late"] = events.get("wrench_late", 0) - waiting
    events = {name: count for name, count in events.items() if count > 0}
    return sum(used.values()), dropped, events
