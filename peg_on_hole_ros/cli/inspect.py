"""`peg-on-hole inspect`: what a bag holds, and what a replay would use of it."""

import argparse
from typing import Any

import numpy as np

from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.cli.bag_and_configuration import (
    Reading,
    configuration_in,
    open_bag,
    print_line,
)
from peg_on_hole_ros.cli.progress import ProgressBar
from peg_on_hole_ros.cli.settings import load
from peg_on_hole_ros.cli.table import table, to_json
from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.errors import BagDamaged, BagError, PegOnHoleError
from peg_on_hole_ros.measurements.orientation import JointOrientation
from peg_on_hole_ros.messages.decode import JOINTS_TYPE, WRENCH_TYPE
from peg_on_hole_ros.messages.stream import orientation_of
from peg_on_hole_ros.number_text import number, quantity
from peg_on_hole_ros.replay.advice import InputOddities, apart, remedy, shifted
from peg_on_hole_ros.replay.bag_settings import completed_settings
from peg_on_hole_ros.replay.run import BadFile, check_bag, sources_of
from peg_on_hole_ros.replay.topic_findings import two_robots
from peg_on_hole_ros.replay.would_use import WouldUse
from peg_on_hole_ros.safe_text import printable


def run(arguments: argparse.Namespace) -> int:
    """Print a report; exit code 4 for a cut-off or damaged bag."""
    (configuration, _), reading = load(arguments.config), Reading.of(arguments)
    bag = open_bag(arguments.bag, reading.most_chunk)
    if arguments.config is None:
        configuration, orientation, error = _stored(bag, configuration, reading)
    else:
        # A file that cannot be used is refused; of what the bag lacks all else is told.
        orientation = orientation_of(configuration)
        configuration, orientation, error = _whole(
            bag, reading.of_topics(configuration), orientation
        )
    result = inspect(bag, configuration, orientation, str(error) if error else None)
    told = None
    if arguments.observability and result["replay"]["possible"]:
        from peg_on_hole_ros.cli import observability_text

        with ProgressBar("filtering") as progress:
            told = observability_text.observe(bag, configuration, progress)
        result["observability"] = observability_text.content(told)
    if told and not arguments.json:
        text = [_topics_text(as_printed(result)), "", "parameters that the motion determines"]
        print("\n".join([*text, *(f"  {line}" for line in observability_text.lines(told))]))
        return _ended(bag, error)
    print(to_json(result) if arguments.json else _topics_text(as_printed(result)))
    return _ended(bag, error)


def _stored(bag, default, reading):
    """Return configuration and orientation of a bag, and why a replay refuses them or None."""
    configuration = reading.of_topics(default)
    try:
        found = configuration_in(bag, reading.any_urdf)
        configuration = reading.of_topics(found or default)
        orientation = orientation_of(configuration)
    except PegOnHoleError as error:
        # All else that the bag holds is told nevertheless.
        return configuration, _Unplaced(configuration.joints.names), error
    return _whole(bag, configuration, orientation)


def _whole(bag, configuration, orientation):
    """Return the same with what the bag adds: the robot's description, the sensor's pose."""
    try:
        whole, line = completed_settings(bag, configuration)
        if line:
            print_line(line)
        if whole.joints != configuration.joints:
            orientation = orientation_of(whole)
        return whole, orientation, None
    except PegOnHoleError as error:
        return configuration, _Unplaced(configuration.joints.names), error


class _Unplaced(JointOrientation):
    """Of a robot whose description is not to be had there are only positions."""

    def _fill(self, positions, outcome, rows):
        rows[:, :3], rows[:, 3:12] = 0.0, np.eye(3).ravel()


def _ended(bag, error):
    if isinstance(error, BadFile):
        raise error
    if bag.damage:
        raise BagDamaged(bag.damage)
    return 0


def inspect(
    bag: Bag,
    configuration: Configuration,
    orientation: JointOrientation,
    trouble: str | None = None,
) -> dict:
    """
    Return the JSON of a report.

    Parameters
    ----------
    bag : Bag
    configuration : Configuration
    orientation : callable
        Returns a text, the reason, for a JointSample that cannot be used.
    trouble : str, optional
        Why a replay would refuse the configuration.

    """
    sources = sources_of(configuration)
    wrench, joints = sources
    result: dict[str, Any] = {
        "bag": printable(bag.path),
        "damage": printable(bag.damage) or None,
        "messages": bag.count,
        "topics": [_topic(bag.topics[name]) for name in sorted(bag.topics)],
        "remarks": bag.remarks({wrench: WRENCH_TYPE, joints: JOINTS_TYPE}),
        "clock": {},
        "oddities": {},
        "replay": {"possible": False, "reason": trouble, "used": {}, "dropped": {}},
    }
    types = {}
    try:
        types = check_bag(bag, configuration)
    except BagError as error:
        result["replay"]["reason"] = trouble or str(error)
        for topic, ros_type in ((wrench, WRENCH_TYPE), (joints, JOINTS_TYPE)):
            info = bag.topics.get(topic)
            if info and info.count and info.types == [ros_type]:
                types[topic] = ros_type
    heard = WouldUse(configuration, orientation, {t: sources[t] for t in sources if t in types})
    seen = InputOddities(configuration.joints, heard.stream.pipeline.failures)
    with ProgressBar("decoding") as progress:
        total, count = sum(bag.topics[topic].count for topic in types), 0
        for batch in bag.batches(types):
            seen.add(batch, sources)
            heard.add(batch)
            count += len(batch)
            progress(count / total)
    for topic, lost in bag.undecodable.items():
        for _ in range(lost):
            heard.stream.unreadable(sources[topic])
    readers = sorted(topic for topic in types if topic in sources)
    result["oddities"] = {topic: seen.odd(sources[topic]) for topic in readers}
    result["clock"] = {topic: heard.statistics[topic].summary() for topic in readers}
    if seen.loop:
        result["remarks"].append(seen.loop)
    of_frames = heard.stream.frames.line(heard.stream.t_ns)
    if of_frames:
        result["oddities"][wrench].append(of_frames)
    of_stamps = heard.stream.pipeline.causes_of_stamps
    result["remarks"] += [*of_stamps, *heard.stream.failed_looks, *bag.foreign()]
    apart_by_name = two_robots({k: v.types for k, v in bag.topics.items()}, wrench, joints)
    if apart_by_name and wrench in readers:
        result["oddities"][wrench].append(apart_by_name)
    read = {sources[topic]: bag.topics[topic].count for topic in readers}
    both = len(read) == 2 and all(heard.usable.values())
    spans = [end for topic in sources for end in heard.span(topic)] if both else []  # type: ignore[union-attr]
    clocks = apart(*spans, configuration) if both else ""  # type: ignore[arg-type, call-arg]
    used, dropped = heard.fates(read) if both and not clocks else heard.alone(read)
    if both:
        offsets = (result["clock"][topic]["log_minus_stamp"]["mean"] for topic in (wrench, joints))
        told = shifted(*offsets, configuration.joints.delay)  # type: ignore[call-arg]
        # A clock that was set, or drifts, has no mean.
        result["oddities"][joints] += [told] if told and not of_stamps else []
    replay = result["replay"]
    replay["used"] = {topic: used[sources[topic]] for topic in readers}
    replay["dropped"] = {
        f"{topic}: {_reason(name)}": count
        for topic in readers
        for name, count in sorted(dropped.items())
        if name.startswith(sources[topic])
    }
    replay["reason"] = replay["reason"] or clocks or None
    if replay["reason"] is None:
        empty = [topic for topic in readers if not used[sources[topic]]]
        lost = {
            name: count
            for name, count in dropped.items()
            if any(name.startswith(sources[topic]) for topic in empty)
        }
        replay["reason"] = (
            f"no message on {' and '.join(empty)} can be used; "
            f"{'; '.join(bag.foreign()) or remedy(lost, configuration.joints.names, seen)}"
            if empty
            else None
        )
        replay["possible"] = replay["reason"] is None
    return result


def _reason(name):
    """Return why messages are dropped without their source and the word for that."""
    return name.partition("_")[2].removeprefix("dropped_").removeprefix("malformed_")


def _topic(info):
    duration = (info.last_ns - info.first_ns) * 1e-9
    return {
        "name": info.name,
        "type": " and ".join(name or "no type" for name in info.types),
        "count": info.count,
        "rate": (info.count - 1) / duration if duration > 0 else None,
        "duration": duration,
    }


def as_printed(content: object) -> object:
    """Return a report in which every text is printable: topics and frames may have any name."""
    if isinstance(content, dict):
        return {printable(key): as_printed(value) for key, value in content.items()}
    if isinstance(content, list):
        return [as_printed(item) for item in content]
    return printable(content) if isinstance(content, str) else content


def _topics_text(result):
    rows = [
        (
            topic["name"],
            topic["type"],
            str(topic["count"]),
            "-" if topic["rate"] is None else f"{topic['rate']:.1f}",
            f"{topic['duration']:.3f}",
        )
        for topic in result["topics"]
    ]
    lines = [f"{result['bag']}: {result['messages']} messages"]
    if result["damage"]:
        lines.append(f"damage: {result['damage']}")
    lines += result["remarks"]
    lines += ["", table(("topic", "type", "messages", "rate [Hz]", "duration [s]"), rows, 2)]
    for topic, clock in result["clock"].items():
        lines += ["", f"clock of {topic}"]
        lines += [f"  {line}" for line in _clock(clock)]
    for topic, told in result["oddities"].items():
        lines += ["", *(f"{topic}: {line}" for line in told)] if told else []
    replay = result["replay"]
    if replay["possible"]:
        lines += ["", "a replay would use"]
    else:
        lines += ["", f"a replay is not possible: {replay['reason']}", "it could use"]
    lines += [f"  {topic}: {count} messages" for topic, count in replay["used"].items()]
    lines += [f"  dropped, {reason}: {count}" for reason, count in replay["dropped"].items()]
    if not any(replay["used"].values()):
        lines.append("  nothing")
    return "\n".join(lines)


def _clock(clock):
    if not clock["stamps"]:
        return ["no stamps"]
    gaps = clock["gaps"]
    longest = (
        f", the longest {quantity(gaps['longest'], 's')}" if gaps["longest"] is not None else ""
    )
    lines = [
        f"median period {quantity(clock['median_period'], 's', 4)}"
        if clock["median_period"]
        else "",
        f"gaps over {quantity(gaps['limit'], 's')}: {gaps['count']}{longest}",
        f"stamps that go backwards: {clock['backwards']}, repeated: {clock['repeated']}",
    ]
    offset = clock["log_minus_stamp"]
    lines.append(
        "log time minus stamp: "
        f"{number(offset['least'] * 1e3)} to {number(offset['greatest'] * 1e3)} ms, "
        f"mean {number(offset['mean'] * 1e3)} ms"
    )
    if clock["trouble"]:
        lines += [f"trouble: {text}" for text in clock["trouble"]]
    return [line for line in lines if line]
