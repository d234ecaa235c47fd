"""`peg-on-hole inspect`: what a bag holds, and what a replay would use of it."""

from collections import Counter
from collections.abc import Callable
from functools import partial

from peg_on_hole_ros.cli.progress import Progress
from peg_on_hole_ros.cli.recording import configuration_in, open_bag
from peg_on_hole_ros.cli.settings import load
from peg_on_hole_ros.cli.table import table, to_json
from peg_on_hole_ros.edges.advice import Seen, apart, remedy, shifted
from peg_on_hole_ros.edges.bags.reader import Bag, absolute
from peg_on_hole_ros.edges.bags.stamps import StampStatistics
from peg_on_hole_ros.edges.messages.decode import (
    JOINTS_TYPE,
    WRENCH_TYPE,
    Malformed,
    joint_sample,
    wrench_sample,
)
from peg_on_hole_ros.edges.messages.stream import orientation_of
from peg_on_hole_ros.edges.oddities import two_robots
from peg_on_hole_ros.edges.replay import check_bag
from peg_on_hole_ros.errors import BagDamaged, BagError, PegOnHoleError
from peg_on_hole_ros.estimation.measurement import NamedPositions
from peg_on_hole_ros.options import Configuration


def run(arguments) -> int:
    """Print a report; exit code 4 for a cut-off or damaged bag."""
    configuration, _ = load(arguments.config)
    bag = open_bag(arguments.bag)
    if arguments.config is None:
        configuration, orientation, trouble = _stored(bag, configuration)
    else:
        orientation, trouble = orientation_of(configuration.joints), None
    result = inspect(bag, configuration, orientation, trouble)
    told = None
    if arguments.observability and result["replay"]["possible"]:
        # It compiles the filter; the rest of the command does without.
        from peg_on_hole_ros.edges import observability_text

        with Progress("filtering") as progress:
            told = observability_text.observe(bag, configuration, progress)
        result["observability"] = observability_text.content(told)
    if told and not arguments.json:
        text = [_text(result), "", "of these parameters the motion tells"]
        print("\n".join([*text, *(f"  {line}" for line in observability_text.lines(told))]))
        return _ended(bag)
    print(to_json(result) if arguments.json else _text(result))
    return _ended(bag)


def _stored(bag, default):
    """Return configuration and orientation of a bag, and why a replay cannot use them or None."""
    configuration = default
    try:
        configuration = configuration_in(bag) or default
        return configuration, orientation_of(configuration.joints), None
    except PegOnHoleError as error:
        # All else that the bag holds is told nevertheless.
        return configuration, NamedPositions(configuration.joints.names), str(error)


def _ended(bag):
    if bag.damage:
        raise BagDamaged(bag.damage)
    return 0


def inspect(
    bag: Bag, configuration: Configuration, orientation: Callable, trouble: str | None = None
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
    wrench, joints = (
        absolute(configuration.topics.wrench),
        absolute(configuration.topics.joint_states),
    )
    result = {
        "bag": str(bag.path),
        "damage": bag.damage or None,
        "messages": bag.count,
        "topics": [_topic(bag.topics[name]) for name in sorted(bag.topics)],
        "clock": {},
        "oddities": {},
        "replay": {"possible": False, "reason": trouble, "used": {}, "dropped": {}},
    }
    try:
        check_bag(bag, configuration)
    except BagError as error:
        result["replay"]["reason"] = trouble or str(error)
    readers = {}
    seen, sources = Seen(configuration.joints.names), {wrench: "wrench", joints: "joints"}
    if bag.topics.get(wrench) and bag.topics[wrench].types == [WRENCH_TYPE]:
        readers[wrench] = wrench_sample
    if bag.topics.get(joints) and bag.topics[joints].types == [JOINTS_TYPE]:
        readers[joints] = lambda message: _joints(message, configuration.joints.names, orientation)
    see = {topic: partial(seen.add, source) for topic, source in sources.items()}
    statistics, used, dropped = _read(bag, readers, configuration.filter.max_gap, see)
    result["oddities"] = {topic: seen.odd(sources[topic]) for topic in sorted(readers)}
    result["clock"] = {topic: statistics[topic].summary() for topic in sorted(readers)}
    apart_by_name = two_robots({k: v.types for k, v in bag.topics.items()}, wrench, joints)
    if apart_by_name and wrench in readers:
        result["oddities"][wrench].append(apart_by_name)
    if all(used[topic] for topic in (wrench, joints)):
        offsets = (result["clock"][topic]["log_minus_stamp"]["mean"] for topic in (wrench, joints))
        told = shifted(*offsets, configuration.joints.delay)
        result["oddities"][joints] += [told] if told else []
    replay = result["replay"]
    replay["used"] = {topic: used[topic] for topic in sorted(readers)}
    replay["dropped"] = {
        f"{topic}: {reason}": count for (topic, reason), count in sorted(dropped.items())
    }
    if replay["reason"] is None:
        empty = [topic for topic in sorted(readers) if not used[topic]]
        if empty:
            lost = {
                f"{sources[topic]}_dropped_{reason}": count
                for (topic, reason), count in sorted(dropped.items())
                if topic in empty
            }
            replay["reason"] = (
                f"no message on {' and '.join(empty)} can be used; "
                f"{remedy(lost, configuration.joints.names, seen)}"
            )
        else:
            replay["reason"] = (
                apart(*statistics[wrench].span, *statistics[joints].span, configuration) or None
            )
            replay["possible"] = replay["reason"] is None
    return result


def _joints(message, names, orientation):
    sample = joint_sample(message, names)
    if isinstance(sample, Malformed):
        return sample
    measurement = orientation(sample)
    return Malformed(measurement) if isinstance(measurement, str) else sample


def _read(bag, readers, max_gap, see):
    statistics = {topic: StampStatistics(max_gap) for topic in readers}
    used, dropped = Counter(), Counter()
    with Progress("decoding") as progress:
        total = sum(bag.topics[topic].count for topic in readers)
        for count, (topic, log_ns, message) in enumerate(bag.messages(readers)):
            sample = readers[topic](message)
            see[topic](message)
            if isinstance(sample, Malformed):
                dropped[topic, sample.reason] += 1
                continue
            used[topic] += 1
            statistics[topic].add(sample.t_ns, log_ns)
            progress(count / total)
    for topic, count in bag.undecodable.items():
        dropped[topic, "unreadable"] += count
    for topic, found in statistics.items():
        if found.repeated:
            used[topic] -= found.repeated
            dropped[topic, "repeated_stamp"] = found.repeated
    return statistics, used, dropped


def _topic(info):
    duration = (info.last_ns - info.first_ns) * 1e-9
    return {
        "name": info.name,
        "type": " and ".join(name or "no type" for name in info.types),
        "count": info.count,
        "rate": (info.count - 1) / duration if duration > 0 else None,
        "duration": duration,
    }


def _text(result):
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
    longest = f", the longest {gaps['longest']:.6g} s" if gaps["longest"] is not None else ""
    lines = [
        f"median period {clock['median_period'] * 1e3:.6g} ms" if clock["median_period"] else "",
        f"gaps over {gaps['limit']:.3g} s: {gaps['count']}{longest}",
        f"stamps that go backwards: {clock['backwards']}, repeated: {clock['repeated']}",
    ]
    offset = clock["log_minus_stamp"]
    lines.append(
        "log time minus stamp: "
        f"{offset['least'] * 1e3:.6g} to {offset['greatest'] * 1e3:.6g} ms, "
        f"mean {offset['mean'] * 1e3:.6g} ms"
    )
    if clock["trouble"]:
        lines += [f"trouble: {text}" for text in clock["trouble"]]
    return [line for line in lines if line]
