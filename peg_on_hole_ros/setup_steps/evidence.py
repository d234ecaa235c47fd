"""What recordings tell of a cell: each function takes what was found in one into its settings."""

from collections.abc import Sequence
from math import degrees, exp

import numpy as np
from scipy.spatial.transform import Rotation

from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.diagnosis.suspected.stated_gravity import contradiction
from peg_on_hole_ros.diagnosis.tuned import STATED_GRAVITY_TEST
from peg_on_hole_ros.identification.low_pass import noise_of_neighbours
from peg_on_hole_ros.identification.noise_levels import NoiseLevel, noise_levels
from peg_on_hole_ros.identification.payload import Payload, StillPoses
from peg_on_hole_ros.identification.presses import Axes, Presses
from peg_on_hole_ros.identification.recording import Recording
from peg_on_hole_ros.identification.selection import NORMAL_95
from peg_on_hole_ros.identification.tuned import HAND_PRESS, STILL_POSE_TEST
from peg_on_hole_ros.identification.weight import weight_of, zero_of
from peg_on_hole_ros.measurements.rotations import rotation_from_rpy
from peg_on_hole_ros.setup_steps.knowledge import (
    FOLLOWS,
    MEASURED,
    STATED,
    UNKNOWN,
    Cell,
    Known,
)

GRAVITY = "scene.gravity"
# What a weight means nothing without.
_WEIGHT_RESTS_ON = GRAVITY, "wrench.axes", "wrench.gravity", "scene.peg_mass"


def take_presses(
    cell: Cell,
    values: dict[str, object],
    pressed: Presses,
    axes: Axes,
    source: str,
    link_rpy: Sequence[float] | None,
) -> None:
    """
    Take sign and axes of the wrench.

    `link_rpy`: how the sensor is turned against the peg by the link that frame_id names, which is
    more exact than a hand; None: no link is named.
    """
    if link_rpy is not None and "wrench.sensor_rpy" in values:
        values = {name: value for name, value in values.items() if name != "wrench.sensor_rpy"}
        _compare_with_link(cell, pressed, source, link_rpy)
    forces = ", ".join(f"{force:.0f}" for force in pressed.forces)
    how = f"three presses of {forces} N in {source}, off by {pressed.missed:.0f} degrees"
    for name, value in values.items():
        before, was = cell.value(name), cell.how(name)
        more = f"; {was.how} it was {before}" if was.kind == STATED and before != value else ""
        cell.put(name, value, Known(MEASURED, how + more))
    if axes.axes != "sensor":
        cell.add("wrench.axes", f"the axes of {axes.axes} by {axes.off:.0f} degrees")
    elif not pressed.snapped and link_rpy is None:
        cell.add("wrench.sensor_rpy", "no quarter turn is near: as exact as the hand alone")
    if axes.alike:
        cell.add(
            "wrench.axes",
            f"the axes of {axes.alike} look the same in this pose: press again at another tilt if "
            "the wrench may be in these",
        )


def _compare_with_link(
    cell: Cell, pressed: Presses, source: str, link_rpy: Sequence[float]
) -> None:
    """Name the peg's axes where the presses fit neither the sensor's link nor any other."""
    turn = rotation_from_rpy(link_rpy).T @ rotation_from_rpy(pressed.found)
    off = degrees(float(Rotation.from_matrix(turn).magnitude()))
    if off > HAND_PRESS.snap:
        cell.contradict(
            "joints.peg_rpy",
            f"by {source}: the pushes along the peg's axes are {off:.0f} degrees off those of the "
            "sensor's link (frame_id), and fit no other link. Check joints.peg_rpy and "
            "joints.tip_frame first, then along which axes the peg was pushed; if the sensor is "
            "mounted otherwise than the description states, set wrench.sensor_pose: stated",
        )


def take_noise(cell: Cell, record: Recording, source: str) -> None:
    """Take the noise of wrench and joints, and the low-pass before the wrench."""
    stated = cell.value("wrench.force_stddev"), cell.value("wrench.torque_stddev")
    filtered = noise_of_neighbours(record.wrench_t, record.wrench, stated)
    force, torque, turned = noise_levels(record, filtered.pole)
    _take_level(cell, "wrench.force_stddev", force, 1.0, source)
    _take_level(cell, "wrench.torque_stddev", torque, 1.0, source)
    # Of the orientation it is in units of what is stated of the joints.
    _take_level(
        cell, "joints.position_stddev", turned, cell.value("joints.position_stddev"), source
    )
    if filtered.cutoff > 0.0:
        value = float(f"{filtered.cutoff:.3g}")
        cell.put(
            "wrench.low_pass",
            value,
            Known(MEASURED, f"correlation of successive wrenches in {source}"),
        )
    elif filtered.enough and not cell.is_given("wrench.low_pass"):
        cell.tell("wrench.low_pass", Known(MEASURED, f"{source} shows none"))


def _take_level(cell: Cell, name: str, level: NoiseLevel | None, unit: float, source: str) -> None:
    if level is None:
        if not cell.is_given(name):
            cell.tell(name, Known(UNKNOWN, f"state it: {source} shows no noise"))
        return
    value = unit * exp(level.log)
    spread = NORMAL_95 * level.stddev * value
    how = f"+- {spread:.2g}, differences of successive samples in {source}"
    cell.put(name, float(f"{value:.3g}"), Known(MEASURED, how))


def take_gravity(cell: Cell, configuration: Configuration, root: str) -> None:
    """Say where gravity comes from; it contradicts the robot where it is stated so."""
    joints = configuration.joints
    if joints.robot_gravity is None:
        return
    if joints.robot_gravity == configuration.scene.gravity:
        link = joints.gravity_link or f"{root}, the root link"
        by = "as stated" if cell.is_given("joints.hole_rpy") else "at its default"
        cell.tell(GRAVITY, Known(FOLLOWS, f"from -z of {link}, by hole_rpy {by}"))
        return
    told = contradiction(configuration)
    if told:
        cell.contradict(GRAVITY, told)


def take_payload(cell: Cell, values: dict[str, object], payload: Payload, source: str) -> None:
    """Take what hangs below the sensor, and the zero."""
    by = f"{payload.poses} still poses in {source}"
    spread = {
        "wrench.payload_mass": f"+- {NORMAL_95 * payload.mass_stddev:.2g} kg",
        "wrench.payload_com": f"+- {_largest(payload.com_stddev)} m",
        "wrench.bias_force": f"+- {_largest(payload.bias_stddev[:3])} N",
        "wrench.bias_torque": f"+- {_largest(payload.bias_stddev[3:])} N m",
    }
    for name, value in values.items():
        how = f"{spread[name]}, {by}" if name in spread else by
        cell.put(name, value, Known(MEASURED, how))
    for line in payload.missing:
        cell.add("wrench.payload_com", line)
    doubt, peg = STILL_POSE_TEST.significance * payload.mass_stddev, cell.value("scene.peg_mass")
    whole = payload.mass + peg
    if payload.mass < -doubt and not any(map(cell.is_contradicted, _WEIGHT_RESTS_ON)):
        if abs(whole) < doubt:
            text = f"state compensated: the controller subtracts the weight, as {by} weigh nothing"
            cell.contradict("wrench.gravity", text)
        else:
            text = (
                f"weigh the peg: {by} weigh {whole:.3g} kg in all, less than the peg of {peg:g} kg"
            )
            cell.contradict("scene.peg_mass", text)
    for basis in _WEIGHT_RESTS_ON:
        if cell.is_contradicted(basis):
            for name in values:
                cell.add(name, f"it rests on {basis}, which is contradicted")


def take_zero(cell: Cell, poses: StillPoses, configuration: Configuration, source: str) -> None:
    """Take the zero from a peg that hangs still, with the payload as it is stated."""
    zero = zero_of(poses, configuration)
    by = f"the still peg in {source}, with the payload as it is stated"
    for kind, unit, part in (("force", "N", slice(0, 3)), ("torque", "N m", slice(3, 6))):
        value = [float(f"{x:.5g}") for x in zero.value[part]]
        spread = float(f"{np.sqrt(np.mean(zero.stddev[part] ** 2)):.2g}")
        how = f"+- {NORMAL_95 * spread:.2g} {unit}, {by}"
        cell.put(f"wrench.bias_{kind}", value, Known(MEASURED, how))
        cell.put(f"wrench.bias_{kind}_stddev", spread, Known(MEASURED, by))


def compare_zero(
    cell: Cell, poses: StillPoses, configuration: Configuration, source: str, most: float
) -> None:
    """
    Compare the zero of poses with a peg that hangs still in another recording.

    Parameters
    ----------
    most : float
        What may be left [N].

    """
    if any(map(cell.is_contradicted, _WEIGHT_RESTS_ON)):
        # The weight of another tilt is another then.
        return
    wrench = configuration.wrench
    left = zero_of(poses, configuration).value[:3] - np.array(wrench.bias_force)
    size = float(np.linalg.norm(left))
    line = f"the bias of the still peg in {source} differs from it by {size:.2g} N"
    if size <= most:
        cell.add("wrench.bias_force", line)
        return
    cell.contradict(
        "wrench.bias_force",
        "the bias has drifted, or something touches or was mounted since: record poses and hang "
        f"again one after the other, or tare (wrench.tare_automatically: true); {line}",
    )


def take_weight(
    cell: Cell,
    poses: StillPoses,
    configuration: Configuration,
    fixed_links: dict[str, np.ndarray],
    source: str,
) -> None:
    """
    Compare gravity with the direction in which still poses show the weight to pull.

    Parameters
    ----------
    fixed_links : dict of str to ndarray, shape (3, 3)
        Axes of the links that stand still, in the root link.

    """
    weight = weight_of(poses, configuration)
    n = len(poses.counts)
    if weight is None:
        cell.add(GRAVITY, f"not tested: {n} still poses in {source}, of at least 3 tilts")
        return
    if cell.is_contradicted("wrench.axes"):
        cell.add(GRAVITY, "not tested, as wrench.axes is contradicted")
        return
    doubt = STILL_POSE_TEST.significance * weight.off_stddev
    said = (
        f"the weight of {n} still poses in {source} is {weight.off:.2g} +- "
        f"{NORMAL_95 * weight.off_stddev:.2g} degrees off it"
    )
    if weight.off <= max(STATED_GRAVITY_TEST.most_off, doubt):
        cell.add(GRAVITY, f"{said}, which is {weight.newtons:.2g} N: it fits")
        return
    R_RH = rotation_from_rpy(configuration.joints.hole_rpy)
    down = R_RH @ weight.direction
    fits = [
        link
        for link, R in fixed_links.items()
        if degrees(np.arccos(np.clip(-R[:, 2] @ down, -1.0, 1.0))) <= STATED_GRAVITY_TEST.most_off
    ]
    g = [float(f"{9.80665 * x:.5g}") for x in weight.direction]
    way = (
        f"set joints.gravity_link: {fits[0]}"
        if fits
        else "if no link of the robot is upright, state joints.gravity_link: stated and "
        f"scene.gravity: {g}"
    )
    cell.contradict(
        GRAVITY,
        f"{way}, unless tip_frame, peg_rpy, sensor_rpy or the order of joints.names is wrong: "
        f"{said}, which is {weight.newtons:.2g} N",
    )


def compare_compensated(cell: Cell, poses: StillPoses, source: str) -> None:
    """Compare the forces of still poses, which are one where a controller takes the weight off."""
    force = poses.wrench[:, :3]
    spread = float(np.sqrt(np.mean(np.sum((force - force.mean(axis=0)) ** 2, axis=1))))
    said = f"the force changes by {spread:.2g} N between {len(force)} still poses in {source}"
    if spread > STILL_POSE_TEST.most_compensated:
        cell.contradict(
            "wrench.gravity", f"state measured: the wrench contains the weight, as {said}"
        )
    else:
        cell.add("wrench.gravity", f"it fits: {said}")


def compare_axes(cell: Cell, left: float, others: dict[str, float], source: str) -> None:
    """
    Compare the axes of the wrench with those in which still poses fit a weight and a zero.

    Parameters
    ----------
    left : float
        What is left in the axes of the settings [N].
    others : dict of str to float
        The same in other axes.

    """
    if left <= STILL_POSE_TEST.most_left:
        return
    said = f"still poses in {source} are {left:.2g} N from any weight and bias"
    best = min(others, key=lambda name: others[name], default="")
    if best and others[best] <= STILL_POSE_TEST.most_left:
        text = (
            f"state wrench.axes: {best}; if presses do not find it, joints.peg_rpy or tip_frame "
            f"is turned about the peg's axis: {said}, and {others[best]:.2g} N with {best}"
        )
    else:
        text = (
            "these axes, joints.peg_rpy, tip_frame or the order of joints.names is wrong, or "
            f"something touched: {said}"
        )
    cell.contradict("wrench.axes", text)


def _largest(stddev: np.ndarray) -> str:
    finite = stddev[np.isfinite(stddev)]
    return f"{NORMAL_95 * finite.max():.2g}" if finite.size else "?"


def shown_value(cell: Cell, configuration: Configuration, name: str) -> object:
    """Return the value that is used of a parameter, which may follow from the robot."""
    if name == GRAVITY:
        return [float(f"{x:.5g}") + 0.0 for x in configuration.scene.gravity]
    value = cell.value(name)
    return list(value) if isinstance(value, tuple) else value
