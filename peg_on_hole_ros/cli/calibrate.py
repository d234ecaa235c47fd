"""`peg-on-hole calibrate`: friction, biases, noise, delay, tilt and clearance from a bag."""

import argparse
from collections import Counter

from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.cli import calibration_text
from peg_on_hole_ros.cli.bag_and_configuration import Reading, open_recording
from peg_on_hole_ros.cli.output_paths import write_text
from peg_on_hole_ros.cli.payload import found_payload
from peg_on_hole_ros.cli.presses import found_axes
from peg_on_hole_ros.cli.progress import ProgressBar
from peg_on_hole_ros.cli.table import table
from peg_on_hole_ros.cli.usable_samples import sound_orientations, sound_wrenches, take_wrench
from peg_on_hole_ros.config.configuration import from_parameters, to_parameters
from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.config.parameters_file import read_parameters, write_parameters
from peg_on_hole_ros.diagnosis.suspected.stated_gravity import contradiction
from peg_on_hole_ros.errors import BagDamaged, BagError, PegOnHoleError
from peg_on_hole_ros.identification.calibration import calibrate
from peg_on_hole_ros.identification.recording import Recording, recording
from peg_on_hole_ros.identification.tuned import CALIBRATED_RECORDING
from peg_on_hole_ros.messages.decode import Malformed
from peg_on_hole_ros.messages.stream import orientation_of
from peg_on_hole_ros.replay.advice import apart
from peg_on_hole_ros.replay.run import check_bag
from peg_on_hole_ros.safe_text import printable

# For what is smoothed over some tens of them; how many slide steadily is told later.
_FEWEST_SAMPLES = 50
_WRITTEN = "written: {0}; use it with `peg-on-hole replay BAG --config {0}`"


def run(arguments: argparse.Namespace) -> int:
    """Calibrate, write the configuration, print what was found; exit code 4 for a damaged bag."""
    bag, configuration, _, stored = open_recording(
        arguments.bag, arguments.config, texts=[arguments.out], reading=Reading.of(arguments)
    )
    start, origin = {}, "the defaults"
    if arguments.config:
        start, origin = read_parameters(arguments.config), arguments.config
        start |= {k: v for k, v in to_parameters(configuration).items() if k.startswith("topics.")}
    elif stored:
        start, origin = to_parameters(configuration), f"that in {bag.path}"
    gravity = configuration.wrench.gravity
    if gravity != "measured" and not arguments.presses:
        raise PegOnHoleError(
            f"wrench.gravity = {gravity!r}: calibrate takes wrenches with wrench.gravity: "
            "measured alone; record them so"
        )
    left_out: Counter[str] = Counter()
    if arguments.presses:
        told, text = found_axes(bag, configuration, left_out)
        values = start | told
        heading = (
            f"Axes and sign of the wrench by presses of {bag.path}; else as {origin}.\n\n{text}"
        )
        text += f"\n{_WRITTEN.format(arguments.out)}"
    elif arguments.payload:
        record = read_recording(bag, configuration, left_out)
        told, text = found_payload(record, configuration)
        values = start | told
        heading = f"Payload and zero by still poses of {bag.path}; else as {origin}.\n\n{text}"
        text += f"\n{_WRITTEN.format(arguments.out)}"
    else:
        record = read_recording(bag, configuration, left_out)
        with ProgressBar("calibrating") as progress:
            found = calibrate(record, configuration, progress)
        values = start | calibration_text.parameters(found, to_parameters(configuration))
        heading = calibration_text.heading(found, str(bag.path), origin)
        text = _calibration_text(found, arguments.out)
    from_parameters(values)
    contradicted = contradiction(configuration)
    if contradicted:
        text, heading = (f"{each}\nscene: {contradicted}" for each in (text, heading))
    if left_out:
        text, heading = (f"{each}\n{_left_out(left_out)}" for each in (text, heading))
    write_text(arguments.out, write_parameters(values, heading))
    print("\n".join(map(printable, text.split("\n"))))
    if bag.damage:
        raise BagDamaged(bag.damage)
    return 0


def _left_out(counts):
    listed = ", ".join(f"{name} {count}" for name, count in sorted(counts.items()))
    return f"left out, by reason: {listed}"


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
                "used, a calibration needs many; `peg-on-hole inspect` says what is wrong"
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
            "own can be used, a calibration needs at least "
            f"{CALIBRATED_RECORDING.fewest_innovations} joint states of steady sliding; "
            "`peg-on-hole inspect` says what is wrong, else record longer, or faster"
        )
    return record


def _calibration_text(found, out):
    lines = [
        table(
            ("", "start", "likeliest", "95 % interval", "unit", "written"),
            calibration_text.rows(found),
        ),
        "",
        f"{found.seconds:.2f} s of steady sliding, {found.innovations} joint states; "
        f"{calibration_text.verdict(found)}",
    ]
    if found.low_pass > 0.0:
        lines.append(calibration_text.filtered(found))
    missing = calibration_text.not_seen(found)
    if missing:
        lines += ["not seen in this recording:"]
        lines += [f"  {line}" for line in missing]
    lines.append(_WRITTEN.format(out))
    return "\n".join(lines)
