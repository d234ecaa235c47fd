"""`peg-on-hole calibrate`: friction, biases, noise, delay, tilt and clearance from a bag."""

import argparse
from collections import Counter

from peg_on_hole_ros.cli import calibration_text
from peg_on_hole_ros.cli.bag_and_configuration import Reading, open_recording
from peg_on_hole_ros.cli.output_paths import write_text
from peg_on_hole_ros.cli.payload import found_payload
from peg_on_hole_ros.cli.presses import found_axes
from peg_on_hole_ros.cli.progress import ProgressBar
from peg_on_hole_ros.cli.recordings import left_out_line, read_recording
from peg_on_hole_ros.cli.table import table
from peg_on_hole_ros.config.configuration import from_parameters, to_parameters
from peg_on_hole_ros.config.parameters_file import read_parameters, write_parameters
from peg_on_hole_ros.diagnosis.suspected.stated_gravity import contradiction
from peg_on_hole_ros.errors import BagDamaged, PegOnHoleError
from peg_on_hole_ros.identification.calibration import calibrate
from peg_on_hole_ros.safe_text import printable

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
            f"wrench.gravity = {gravity!r}: calibrate needs wrench.gravity: measured; record the "
            "wrench without compensation of the weight"
        )
    left_out: Counter[str] = Counter()
    if arguments.presses:
        pressed = found_axes(bag, configuration, left_out)
        values, text = start | pressed.values, pressed.text
        heading = (
            f"Axes and sign of the wrench from presses in {bag.path}; all else from {origin}."
            f"\n\n{text}"
        )
        text += f"\n{_WRITTEN.format(arguments.out)}"
    elif arguments.payload:
        record = read_recording(bag, configuration, left_out)
        weighed = found_payload(record, configuration)
        values, text = start | weighed.values, weighed.text
        heading = (
            f"Payload and bias from still poses in {bag.path}; all else from {origin}.\n\n{text}"
        )
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
        text, heading = (f"{each}\n{left_out_line(left_out)}" for each in (text, heading))
    write_text(arguments.out, write_parameters(values, heading))
    print("\n".join(map(printable, text.split("\n"))))
    if bag.damage:
        raise BagDamaged(bag.damage)
    return 0


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
