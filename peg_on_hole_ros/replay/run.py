"""Run a bag through the stream that the node runs, message by message in the bag's order."""

import json
import time
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from functools import partial
from typing import NamedTuple, Protocol

import numpy as np

from peg_on_hole_ros.bags.arrival_record import EVENT_TOPIC
from peg_on_hole_ros.bags.batch import Batch, Item, arrivals_of
from peg_on_hole_ros.bags.reader import Bag, absolute
from peg_on_hole_ros.bags.writer import CONFIGURATION_METADATA, URDF_METADATA
from peg_on_hole_ros.config.configuration import from_parameters, node_options
from peg_on_hole_ros.config.options import Configuration, NodeOptions
from peg_on_hole_ros.diagnosis.guarded_looks import Failures
from peg_on_hole_ros.errors import BagError, PegOnHoleError
from peg_on_hole_ros.estimator.methods.method import Make
from peg_on_hole_ros.estimator.methods.registry import METHODS, make_filter
from peg_on_hole_ros.estimator.settings import default_settings
from peg_on_hole_ros.estimator.smoother import Smoother
from peg_on_hole_ros.messages.beside_estimates import STRING, Message, smoothed_messages
from peg_on_hole_ros.messages.columns import OutputColumns
from peg_on_hole_ros.messages.decode import JOINTS_TYPE, WRENCH_TYPE
from peg_on_hole_ros.messages.stream import (
    MessageStream,
    is_event,
    message_stream,
    orientation_of,
)
from peg_on_hole_ros.messages.transforms import static_transform
from peg_on_hole_ros.messages.warm_up import warm
from peg_on_hole_ros.records import Arrivals
from peg_on_hole_ros.replay.advice import InputOddities, lines, remedy
from peg_on_hole_ros.replay.bag_settings import completed_settings
from peg_on_hole_ros.robot.frame_tree import FrameTree, frame_tree
from peg_on_hole_ros.robot.urdf_source import FROM_TOPIC, check_regular, urdf_path

_REMEDY = (
    "name the topics by --wrench-topic and --joints-topic, or in the configuration "
    "(topics.wrench, topics.joint_states)"
)


class BadFile(PegOnHoleError):
    """A bag names a file that is none to be read, such as a device."""


class Sink(Protocol):
    """Takes what a replay gives."""

    def take(self, columns: OutputColumns) -> None:
        """Take the outputs of stamps that rise."""


class SmoothedSink(Protocol):
    """Takes the smoothed state."""

    def add(self, t_ns: int, messages: list[Message]) -> None:
        """Take the messages of one stamp [ns]."""


class InputObserver(Protocol):
    """Sees what is read, before the sinks are given what comes of it."""

    def read(self, sample: object) -> None:
        """See a sample, or what is wrong with it."""

    def take_inputs(self, arrivals: Arrivals, begin: int, end: int) -> None:
        """See messages by their places, all of them sound."""


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
    by_source : dict of str to int
        Messages in the bag of `wrench` and `joints`.
    seen : InputOddities
        What they had.
    t_ns : int
        Last stamp of an output [ns].
    ending : list of Message
        What the end of the bag made known, such as a try that was under way.
    causes : list of str
        What makes the numbers doubtful by the data, a line each.
    contradicted : list of str
        Settings that the data have contradicted: some of these.
    joints_explained : bool
        Whether these say what is odd about the values of joint states.
    reactions_are_void : bool
        Whether reactions rest on one of these.
    failures : Failures
        Side looks that failed.

    """

    read: int
    used: int
    dropped: dict[str, int]
    events: dict[str, int]
    seconds: float
    by_source: dict[str, int]
    seen: InputOddities
    t_ns: int
    ending: list[Message]
    causes: list[str]
    contradicted: list[str]
    joints_explained: bool
    reactions_are_void: bool
    failures: Failures

    @property
    def messages(self) -> dict[str, int | dict[str, int]]:
        """What became of the messages, as a summary has it."""
        return {
            "read": self.read, "used": self.used, "dropped": self.dropped, "events": self.events,
        }  # fmt: skip

    def doubts(self, content: dict, configuration: Configuration) -> list[str]:
        """Return a line for each thing that makes its numbers, a summary's content, doubtful."""
        return lines(
            {"messages": self.messages, **content}, self.by_source, configuration, self.seen,
            self.causes, self.joints_explained,
        )  # fmt: skip


def sources_of(configuration: Configuration) -> dict[str, str]:
    """Return which topics of a bag are `wrench` and `joints`, in this order."""
    topics = configuration.topics
    return {absolute(topics.wrench): "wrench", absolute(topics.joint_states): "joints"}


def check_bag(bag: Bag, configuration: Configuration) -> dict[str, str]:
    """Return the topics that a replay reads with their types, or raise BagError."""
    needed = dict(zip(sources_of(configuration), (WRENCH_TYPE, JOINTS_TYPE)))
    bag.require(needed, _REMEDY)
    events = bag.topics.get(EVENT_TOPIC)
    return needed | ({EVENT_TOPIC: STRING} if events and events.types == [STRING] else {})


def stored_configuration(bag: Bag, any_urdf: bool = False) -> Configuration | None:
    """
    Return the configuration that a bag carries, or None.

    Parameters
    ----------
    bag : Bag
    any_urdf : bool
        Whether it may choose which file is read as URDF, where it has not the text itself.

    Raises
    ------
    PegOnHoleError
        It is not one of this version, or names a file that it may not choose.

    """
    configuration = _of_stored(bag, from_parameters)
    if configuration is None or configuration.joints.source != "robot":
        return configuration
    joints = configuration.joints
    text = bag.metadata.get(URDF_METADATA, {}).get("text", "")
    if text:
        # No file is read, so none is to blame.
        told = f"the robot's description in {bag.path} (metadata {URDF_METADATA})"
        joints = replace(joints, description=text, described_by=told)
        return replace(configuration, joints=joints)
    if joints.urdf == FROM_TOPIC:
        return configuration
    try:
        check_regular(urdf_path(joints))
    except PegOnHoleError as error:
        raise BadFile(f"the configuration in {bag.path}: {error}") from None
    if not any_urdf:
        raise PegOnHoleError(
            f"the configuration in {bag.path} names a file as URDF, {joints.urdf}, and a bag does "
            "not choose which files are read: confirm it with --bag-urdf, or give a configuration "
            "with --config"
        )
    return configuration


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
        why = str(error)
    except RecursionError:
        why = "a value lies deeper within others than any parameter does"
    raise PegOnHoleError(
        f"the configuration in {bag.path} cannot be used ({why}); give one with --config"
    )


def replay_bag(
    bag: Bag,
    configuration: Configuration,
    markers_rate: float,
    sinks: Iterable[Sink],
    progress: Callable[[float], None] | None = None,
    smoothed: SmoothedSink | None = None,
    watch: InputObserver | None = None,
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
    smoothed : SmoothedSink, optional
        Is given the smoothed state of every stamp, after all other output.
    watch : InputObserver, optional

    Raises
    ------
    PegOnHoleError
        The robot's description cannot be used, or contradicts what is stated of the sensor.
    BagError
        A needed topic is missing or of another type, no message could be used, or no joint state
        is of a time of the wrench's.
    """
    needed = check_bag(bag, configuration)
    sources = sources_of(configuration)
    total = sum(bag.topics[topic].count for topic in needed)
    sinks = list(sinks)
    # A URDF that cannot be used is refused before the long work of compiling.
    configuration = completed_settings(bag, configuration).configuration
    orientation_of(configuration)
    warm(configuration)
    stream = message_stream(
        configuration, markers_rate, _maker(configuration, smoothed is not None), offline=True
    )
    seen = InputOddities(configuration.joints, stream.pipeline.failures)
    unreadable = Counter(bag.undecodable)
    tree: FrameTree | None = frame_tree(configuration)
    begun, count = time.perf_counter(), 0
    for batch in bag.batches(needed):
        seen.add(batch, sources)
        for columns in played(stream, batch, configuration, sources, watch):
            if tree is not None:
                placed, tree = static_transform(tree, int(columns.t_ns[0])), None
                columns.add([(0, [placed])] if placed else [])
            for sink in sinks:
                sink.take(columns)
        count += len(batch)
        if progress:
            progress(count / total)
    if smoothed:
        hole = configuration.frames.hole
        for t_ns, state, covariance in zip(*stream.pipeline.filter.smooth()):  # type: ignore[attr-defined]
            smoothed.add(t_ns, smoothed_messages(t_ns, state, covariance, hole))
    ending = stream.finish()
    seconds = time.perf_counter() - begun
    for topic, source in sources.items():
        for _ in range(bag.undecodable[topic] - unreadable[topic]):
            stream.unreadable(source)
    read = {source: bag.topics[topic].count for topic, source in sources.items()}
    apart = seen.apart(configuration)
    if apart:
        raise BagError(f"{bag.path}: {apart}")
    used, dropped, events = fates(stream.counts, read)
    if not stream.counts.get("wrench_used") and bag.foreign():
        raise BagError(f"{bag.path}: {'; '.join(bag.foreign())}")
    if not stream.counts.get("wrench_used"):
        reasons = ", ".join(f"{reason} {n}" for reason, n in dropped.items())
        raise BagError(
            f"{bag.path}: no wrench of {read['wrench']} could be used: {reasons}; "
            f"{remedy(dropped, configuration.joints.names, seen)}"
        )
    total = sum(read.values())
    told = sum(used.values()), dropped, events
    return Replayed(
        total,
        *told,
        seconds,
        read,
        seen,
        stream.t_ns,
        ending,
        stream.causes,
        stream.contradicted,
        stream.pipeline.joints_explained,
        stream.pipeline.reactions_are_void,
        stream.pipeline.failures,
    )


def _maker(configuration: Configuration, smooths: bool) -> Make:
    """Return what makes the estimator that the settings name, keeping what it smooths or not."""
    if not smooths:
        return make_filter
    method = configuration.filter.method
    settings = METHODS[method].settings
    if settings is None:
        raise PegOnHoleError(
            f"filter.method = {method!r} cannot be smoothed: leave --smooth out, or name another"
        )
    return partial(Smoother, settings=default_settings(**settings))


def played(
    stream: MessageStream,
    batch: Batch,
    configuration: Configuration,
    sources: dict[str, str],
    watch: InputObserver | None = None,
) -> Iterator[OutputColumns]:
    """
    Hand a batch to a stream; yield outputs as they come.

    Parameters
    ----------
    stream : MessageStream
    batch : Batch
    configuration : Configuration
    sources : dict of str to str
        See `sources_of`.
    watch : InputObserver, optional

    """
    joints = configuration.joints
    orientation = stream.pipeline.orientation
    arrivals = arrivals_of(batch, sources, joints, orientation, stream.frames)
    place = 0
    while place < len(batch):
        begin = place
        place, columns = stream.take(arrivals, place)
        # What came behind the last wrench is seen after what that gives.
        wrenches = np.flatnonzero(arrivals.of_wrench[begin:place])
        behind = begin + int(wrenches[-1]) + 1 if len(wrenches) else begin
        if watch is not None:
            watch.take_inputs(arrivals, begin, behind)
        if columns is not None:
            yield columns
        if watch is not None:
            watch.take_inputs(arrivals, behind, place)
        if place < len(batch) and (place == begin or not arrivals.sound[place]):
            item = batch.item(place, joints.names)
            if watch is not None and item.topic in sources:
                watch.read(item.sample)
            columns = hand_over(stream, item, sources)
            if stream.pipeline.orientation is not orientation:
                # What was called has set the noise that orientations are given.
                orientation = stream.pipeline.orientation
                arrivals = arrivals_of(batch, sources, joints, orientation, stream.frames)
            place += 1
            if columns is not None:
                yield columns


def hand_over(stream: MessageStream, item: Item, sources: dict[str, str]) -> OutputColumns | None:
    """
    Hand a message of a bag to a stream as the node has it; return what it makes known.

    `sources` are as of `sources_of`; other topics call reset or tare.
    """
    source = sources.get(item.topic)
    if source == "wrench":
        return stream.take_wrench(item.sample, item.frame)
    if source == "joints":
        stream.take_joints(item.sample)
    # A name that this version does not know changes nothing that it could repeat.
    elif is_event(item.sample.data):
        stream.on_event(item.sample.data)
    return None


def fates(
    counts: dict[str, int], read: dict[str, int]
) -> tuple[dict[str, int], dict[str, int], dict[str, int]]:
    """
    Return how many messages were used, and those dropped and other events, by reason.

    Parameters
    ----------
    counts : dict of str to int
        Of a stream.
    read : dict of str to int
        Messages in the bag of `wrench` and `joints`; those used are returned likewise.

    """
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
    return used, dropped, events
