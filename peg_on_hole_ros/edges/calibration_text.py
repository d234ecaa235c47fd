"""What a calibration found, in words and as parameters."""

from math import degrees, isfinite

from peg_on_hole_ros.estimation.calibration import Calibration, Estimate

# A mean NIS outside of this, over hundreds of innovations, is no chance.
NIS_LOW, NIS_HIGH = 2.5, 3.6

WORDS = {
    "friction": "friction",
    **{f"bias_force_{axis}": f"force bias along {axis}" for axis in "xyz"},
    **{f"bias_torque_{axis}": f"torque bias about {axis}" for axis in "xyz"},
    "tilt_x": "tilt of gravity along x of the hole",
    "tilt_y": "tilt of gravity along y of the hole",
    "delay": "delay of the joint states",
    "clearance": "clearance (D - d)",
    "force_stddev": "noise of each force component",
    "torque_stddev": "noise of each torque component",
    "position_stddev": "noise of the orientation",
}


def parameters(found: Calibration) -> dict[str, object]:
    """Return the parameters that a calibration sets; of what was not seen, the start's."""
    configuration = found.configuration
    scene, wrench, joints = configuration.scene, configuration.wrench, configuration.joints
    values = {
        "scene.peg_diameter": scene.peg_diameter,
        "scene.friction": scene.friction,
        "scene.gravity": scene.gravity,
        "wrench.force_stddev": wrench.force_stddev,
        "wrench.torque_stddev": wrench.torque_stddev,
        "wrench.bias_force": wrench.bias_force,
        "wrench.bias_torque": wrench.bias_torque,
        "joints.position_stddev": joints.position_stddev,
        "joints.delay": joints.delay,
    }
    for one in found.estimates:
        if one.name in ("friction", "clearance") and one.seen:
            values[f"scene.{one.name}_stddev"] = (one.high - one.low) / (2 * 1.96)
    # Nine digits: clearances of 0.1 mm to a nanometre, and no rounding tails.
    return {
        name: [_short(v) for v in value] if isinstance(value, (tuple, list)) else _short(value)
        for name, value in values.items()
    }


def _short(value):
    return float(f"{value:.9g}")


def rows(found: Calibration) -> list[tuple[str, str, str, str]]:
    """Return (what, value, 95 % interval, unit) as texts."""
    return [_row(estimate) for estimate in found.estimates]


def _row(estimate: Estimate):
    unit, factor = estimate.unit, 1.0
    for plain, shown, scale in (("rad", "mrad", 1e3), ("s", "ms", 1e3), ("m", "um", 1e6)):
        if estimate.unit == plain:
            unit, factor = shown, scale
    value = f"{estimate.value * factor:.5g}"
    if not estimate.seen:
        return WORDS[estimate.name], value, "not seen: kept", unit
    interval = f"{estimate.low * factor:.5g} to {estimate.high * factor:.5g}"
    return WORDS[estimate.name], value, interval, unit


def not_seen(found: Calibration) -> list[str]:
    """Return one sentence for each parameter that the recording does not tell, and a remedy."""
    return [
        f"{WORDS[estimate.name]}: {_reason(estimate, found)}"
        for estimate in found.estimates
        if not estimate.seen
    ]


def _reason(estimate, found):
    name = estimate.name
    if name.endswith("_stddev"):
        return "too few samples in a row at an even rate to tell noise from motion"
    if name == "clearance":
        reason = (
            f"not seen, the tilt came no nearer to gamma0 than {found.least_tilt:.2g} times; "
            "record a peg that is closed to 1.1 times gamma0 or less"
        )
    elif name == "delay":
        reason = "not seen, the motion was too even; record quick changes of speed"
    elif name == "bias_torque_z":
        ways = "both ways" if found.both_ways else "one way only"
        reason = (
            f"only while the peg turns both ways about its axis; it turned {ways}, by "
            f"{degrees(found.turn):.0f} degrees"
        )
    elif name.startswith(("bias", "tilt")):
        reason = (
            "told from friction, weight and the other biases only while the peg turns about its "
            f"axis and the hole's; it turned by {degrees(found.turn):.0f} degrees: record half a "
            "turn or more, both ways"
        )
    else:
        reason = "not seen, the contacts slid too little"
    if estimate.partner:
        reason += f" (in this recording it looks like {WORDS[estimate.partner]})"
    return reason


def verdict(found: Calibration) -> str:
    """Return how well the calibrated model explains the recording."""
    text = f"mean NIS {found.nis:.2f} (3 if all is right)"
    if found.nis > NIS_HIGH:
        return (
            f"{text}: the recording holds more than the model and its noise explain; look for a "
            "wrong sensor pose (wrench.sensor_xyz, sensor_rpy), mass, payload or diameter, for "
            "filtered wrenches, or for a soft peg. The intervals are too narrow for that"
        )
    if found.nis < NIS_LOW:
        return (
            f"{text}: the recording holds less noise than its samples differ by; correlated or "
            "repeated samples look like that"
        )
    return f"{text}: the model explains the recording"


def heading(found: Calibration, bag: str, start: str) -> str:
    """Return the comment above the configuration: origin, values, intervals, what is missing."""
    before = f"{found.nis_before:.2f}" if isfinite(found.nis_before) else "none: no motion fits"
    lines = [
        f"Calibrated from {bag}, started from {start}:",
        f"{found.seconds:.2f} s of steady sliding on three contacts, {found.innovations} joint",
        f"states. {verdict(found)};",
        f"before: {before}.",
        "",
        "Values with 95 % intervals:",
    ]
    for what, value, interval, unit in rows(found):
        lines.append(f"  {what}: {value} {unit} ({interval})".replace("  (", " ("))
    missing = not_seen(found)
    if missing:
        lines += ["", "Not seen in this recording, kept as at the start:"]
        lines += [f"  {line}" for line in missing]
    return "\n".join(lines)
