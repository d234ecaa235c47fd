"""What a calibration found, in words and as parameters."""

from math import degrees, sqrt

from peg_on_hole_ros.config.configuration import to_parameters
from peg_on_hole_ros.identification.calibration import CalibratedParameter, Calibration
from peg_on_hole_ros.identification.selection import NORMAL_95

# A mean NIS outside of this, over hundreds of innovations, is no chance. Below 3 it is where a peg
# is held more steadily than the estimator takes for granted.
NIS_LOW, NIS_HIGH = 1.8, 3.6

WORDS = {
    "friction": "friction",
    **{f"bias_force_{axis}": f"force bias along {axis}" for axis in "xyz"},
    **{f"bias_torque_{axis}": f"torque bias about {axis}" for axis in "xyz"},
    "tilt_x": "tilt of the hole about its x",
    "tilt_y": "tilt of the hole about its y",
    "delay": "delay of the joint states",
    "clearance": "clearance (D - d)",
    "force_stddev": "noise of each force component",
    "torque_stddev": "noise of each torque component",
    "position_stddev": "noise of the orientation",
}
# Parameters that a calibration may change.
CALIBRATED_PARAMETERS = (
    "scene.peg_diameter",
    "scene.friction",
    "scene.gravity",
    "wrench.force_stddev",
    "wrench.torque_stddev",
    "wrench.low_pass",
    "wrench.bias_force",
    "wrench.bias_torque",
    "joints.position_stddev",
    "joints.delay",
    "joints.hole_rpy",
)
# Turns both ways tell the clearance below so many times gamma0 (docs/command_line.md).
NEAR_TILT = 2.0
# Of a wrench's noise: a bias that is known better than this needs no states.
NEGLIGIBLE_BIAS_SHARE = 0.1
SHOWN = {"rad": ("mrad", 1e3), "s": ("ms", 1e3), "m": ("um", 1e6)}


def parameters(found: Calibration, start: dict[str, object]) -> dict[str, object]:
    """Return the parameters that differ from the start's, which are given in full."""
    now = to_parameters(found.configuration)
    values = {
        name: _short(now[name]) for name in CALIBRATED_PARAMETERS if now[name] != start[name]
    }
    spreads = {"clearance": "scene.clearance_stddev", "delay": "joints.delay_stddev"}
    for one in found.estimates:
        if one.name in spreads and one.changed:
            values[spreads[one.name]] = _short((one.high - one.low) / 2 / NORMAL_95)
    wrench = found.configuration.wrench
    for bias, noise in (
        ("bias_force", wrench.force_stddev),
        ("bias_torque", wrench.torque_stddev),
    ):
        stddev = _of_components(found, bias)
        if stddev > NEGLIGIBLE_BIAS_SHARE * noise:
            values[f"wrench.{bias}_stddev"] = _short(stddev)
    return values


def _of_components(found, bias):
    """Return the root mean square of how well the components that are written are known."""
    own = [one for one in found.estimates if one.name.startswith(bias) and one.changed]
    squares = [((one.high - one.low) / 2 / NORMAL_95) ** 2 for one in own]
    return sqrt(sum(squares) / len(own)) if own else 0.0


def _short(value):
    # Nine digits: clearances of 0.1 mm to a nanometre, and no rounding tails.
    return list(map(_short, value)) if isinstance(value, list) else float(f"{value:.9g}")


def rows(found: Calibration) -> list[tuple[str, ...]]:
    """Return (what, start, most likely, 95 % interval, unit, what is written) as texts."""
    return [_row(estimate) for estimate in found.estimates]


def _row(one: CalibratedParameter):
    unit, factor = SHOWN.get(one.unit, (one.unit, 1.0))
    if one.name == "position_stddev":
        unit, factor = "mrad", 1e3
    start, best, low, high, value = (f"{factor * number:.5g}" for number in one[2:7])
    interval = f"{low} to {high}"
    if one.changed:
        return WORDS[one.name], start, best, interval, unit, value
    if not one.seen:
        return WORDS[one.name], start, "?", "?", unit, "kept: not seen"
    inside = one.low <= one.start <= one.high
    why = f"not distinct from {start}" if inside else "not significant among all"
    return WORDS[one.name], start, best, interval, unit, f"kept: {why}"


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
        reason = "record more samples in a row, or state the noise of the sensor at rest"
    elif name == "clearance":
        reason = _clearance(found)
    elif name == "delay":
        reason = "record quick changes of speed and of force: the motion was too even"
    elif name == "bias_torque_z":
        ways = "both ways" if found.both_ways else "one way only"
        reason = (
            "record turns both ways about the peg's axis, which distinguish it from friction; "
            f"here the peg turned {ways}, by {degrees(found.turn):.0f} degrees"
        )
    elif name.startswith(("bias", "tilt")):
        reason = (
            "record half a turn or more about the axes of peg and hole, both ways, which "
            "distinguishes it from friction, weight and the other biases; here the peg turned by "
            f"{degrees(found.turn):.0f} degrees"
        )
    else:
        reason = "the contacts slid too little"
    if estimate.alike:
        others = [WORDS[other] for other in estimate.alike]
        reason += f" (in this motion it looks like {_listed(others)})"
    if estimate.changed:
        reason += "; it is changed nevertheless, because the start does not explain the recording"
    return reason


def _listed(words):
    return " and ".join(filter(None, [", ".join(words[:-1]), words[-1]]))


def _clearance(found):
    # As it is shown, so that nothing is asked for that seems to be there.
    tilt = round(found.least_tilt, 2)
    if not found.both_ways:
        return (
            f"record turns both ways about the peg's axis below {NEAR_TILT:g} times gamma0: they "
            "distinguish it best from friction, tilt and biases, and here the peg did not turn "
            "both ways"
        )
    if tilt > NEAR_TILT:
        return (
            f"record turns both ways below {NEAR_TILT:g} times gamma0: the peg turned both "
            f"ways, but while it slid steadily its tilt was never below {tilt:.2f} times gamma0"
        )
    return (
        "record such turns for longer: the peg turned both ways, and while it slid steadily its "
        f"tilt came down to {tilt:.2f} times gamma0"
    )


def verdict(found: Calibration) -> str:
    """Return how well the calibrated model explains the recording."""
    text = f"mean NIS {found.nis:.2f} (3 if all is right)"
    if found.nis > NIS_HIGH:
        return (
            f"{text}: model and noise do not explain the recording, and the intervals are too "
            "narrow. Check wrench.sensor_xyz, sensor_rpy, mass, payload and diameters, and "
            "whether wrenches are filtered or the peg is soft"
        )
    if found.nis < NIS_LOW:
        return (
            f"{text}: the recording has less noise than the configuration states; correlated or "
            "repeated samples look the same"
        )
    return f"{text}: the model explains the recording"


def filtered(found: Calibration) -> str:
    """Return a line on a low-pass that the noise of the wrench shows; empty: none."""
    if found.low_pass == 0.0:
        return ""
    return (
        "the noise of successive wrenches is correlated, as behind a low-pass of "
        f"{found.low_pass:.2g} Hz: wrench.low_pass is written, and the noise before it"
    )


def heading(found: Calibration, bag: str, start: str) -> str:
    """Return the comment above the configuration: origin, values, intervals, what is missing."""
    lines = [
        f"Calibrated from {bag}, started from {start}:",
        f"{found.seconds:.2f} s of steady sliding on three contacts, {found.innovations} joint",
        f"states. {verdict(found)};",
        f"before: mean NIS {found.nis_before:.2f}.",
        "",
        "Most likely values with 95 % intervals, and what is written:",
    ]
    for what, _, best, interval, unit, written in rows(found):
        lines.append(f"  {what} {unit}: {best} ({interval}) -> {written}".replace(" :", ":"))
    if found.low_pass > 0.0:
        lines += ["", filtered(found)]
    missing = not_seen(found)
    if missing:
        lines += ["", "Not seen in this recording:"]
        lines += [f"  {line}" for line in missing]
    return "\n".join(lines)
