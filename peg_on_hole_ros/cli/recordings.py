"""Recordings as the arrays that a calibration takes, whatever is wrong in them."""

from collections import Counter

from peg_on_hole_ros.bags.reader import Bag, absolute
from peg_on_hole_ros.cli.progress import ProgressBar
from peg_on_hole_ros.cli.usable_samples import sound_orientations, sound_wrenches, take_wrench
from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.errors import BagError
from peg_on_hole_ros.identification.recording import Recording, recording
from peg_on_hole_ros.identification.tuned import CALIBRATED_RECORDING
from peg_on_hole_ros.messages.decode import JOINTS_TYPE, WRENCH_TYPE, Malformed
from peg_on_hole_ros.messages.stream import orientation_of
from peg_on_hole_ros.records import AngleMeasurement, JointSample, WrenchSample
from peg_on_hole_ros.replay.advice import apart
from peg_on_hole_ros.replay.run import check_bag

# For what is smoothed over some tens of them; how many slide steadily is told later.
_FEWEST_SAMPLES = 50


def left_out_line(counts: Counter[str]) -> str:
    """Return which messages were left out, by reason."""
    listed = ", ".join(f"{name} {count}" for name, count in sorted(counts.items()))
    return f"left out, by reason: {listed}"


def usable_wrenches(
    bag: Bag, configuration: Configuration, left_out: Counter[str]
) -> list[WrenchSample]:
    """
    Return the wrenches of a bag that can be used; others are counted in `left_out`, by reason.

    Raises
    ------
    BagError
        There is no such topic.

    """
    types = {absolute(configuration.topics.wrench): WRENCH_TYPE}
    bag.require(types)
    total = sum(bag.topics[topic].count for topic in types)
    samples: list[WrenchSample] = []
    with ProgressBar("decoding") as progress:
        for count, item in enumerate(bag.items(types)):
            progress(count / total)
            take_wrench(item.sample, samples, left_out)
    return sound_wrenches(samples, left_out)


def measured_orientations(bag: Bag, configuration: Configuration) -> list[AngleMeasurement]:
    """Return the orientations of a bag that can be used; none where it has no joint states."""
    topic = absolute(configuration.topics.joint_states)
    info = bag.topics.get(topic)
    if info is None or info.types not in ([JOINTS_TYPE], [""]):
        return []
    orientation, joints = orientation_of(configuration), configuration.joints
    with ProgressBar("decoding") as progress:
        measured = []
        for count, item in enumerate(bag.items({topic: JOINTS_TYPE}, joints.names)):
            progress(count / info.count)
            if isinstance(item.sample, JointSample):
                measured.append(orientation(item.sample))
    return [each for each in measured if not isinstance(each, str)]


def read_recording(
    bag: Bag, configuration: Configuration, left_out: Counter[str] | None = None
) -> Recording:
    """
    Return the wrenches and orientations of a bag that can be used.

    Parameters
    ----------
    bag : Bag
    configuration : Configuration
    left_out : Counter, optional
        Counted up: messages that are left out, by reason, as a replay names them.

    Raises
    ------
    BagError
        A needed topic is missing, of another type, or has too few messages that can be used; or
        the two have no time in common.

    """
    needed = check_bag(bag, configuration)
    wrench_topic, joints_topic = list(needed)[:2]
    orientation = orientation_of(configuration)
    wrenches, measurements = [], []
    left_out = Counter() if left_out is None else left_out
    total = sum(bag.topics[topic].count for topic in (wrench_topic, joints_topic))
    with ProgressBar("decoding") as progress:
        items = bag.items(dict(list(needed.items())[:2]), configuration.joints.names)
        for count, item in enumerate(items):
            progress(count / total)
            if item.topic == wrench_topic:
                take_wrench(item.sample, wrenches, left_out)
                continue
            if isinstance(item.sample, Malformed):
                left_out[f"joints_dropped_malformed_{item.sample.reason}"] += 1
                continue
            measurement = orientation(item.sample)
            if isinstance(measurement, str):
                left_out[f"joints_dropped_{measurement}"] += 1
            else:
                measurements.append(measurement)
    for topic, kept in ((wrench_topic, wrenches), (joints_topic, measurements)):
        if len(kept) < 2:
            raise BagError(
                f"{bag.path}: {len(kept)} of {bag.topics[topic].count} messages on {topic} can be "
                "used, and a calibration needs many; `peg-on-hole inspect` reports the reason"
            )
    stamps = [[sample.t_ns for sample in kept] for kept in (wrenches, measurements)]
    spans = (end(of) for of in stamps for end in (min, max))
    clocks = apart(*spans, configuration)  # type: ignore[arg-type, call-arg]
    if clocks:
        raise BagError(f"{bag.path}: {clocks}")
    record = recording(
        sound_wrenches(wrenches, left_out), sound_orientations(measurements, left_out)
    )
    counts = len(record.wrench_t), len(record.joint_t)
    if min(counts) < _FEWEST_SAMPLES:
        raise BagError(
            f"{bag.path}: {counts[0]} wrenches and {counts[1]} joint states with stamps of their "
            "own can be used, and a calibration needs at least "
            f"{CALIBRATED_RECORDING.fewest_innovations} joint states of steady sliding; "
            "record longer, or at a higher rate, if `peg-on-hole inspect` reports no other reason"
        )
    return record
