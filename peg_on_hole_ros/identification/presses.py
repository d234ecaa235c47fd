"""How a sensor lies on the peg, and whose wrench it reports, from three presses of a hand."""

from collections.abc import Sequence
from math import degrees
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.identification.tuned import HAND_PRESS
from peg_on_hole_ros.measurements.rotations import quarter_turns, rotation_from_rpy, rpy_of
from peg_on_hole_ros.mechanics.reference import peg_axes
from peg_on_hole_ros.records import AngleMeasurement, WrenchSample

# Pushes on the peg, peg axes: up at its lower end, then along x, then along y.
PUSHES = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]).T


class Presses(NamedTuple):
    """
    What three presses tell.

    Attributes
    ----------
    acts_on : str
    rpy : tuple of 3 float
        Sensor axes in the peg frame [rad], a quarter turn where one is near.
    found : tuple of 3 float
        The same as the hand had it.
    turned : float
        Between the two, 0 where they are one [degrees].
    missed : float
        By how much the presses were off their directions, root mean square [degrees].
    forces : ndarray, shape (3,)
        Of the presses [N].
    snapped : bool
        Whether a quarter turn is near.

    """

    acts_on: str
    rpy: tuple[float, float, float]
    found: tuple[float, float, float]
    turned: float
    missed: float
    forces: np.ndarray
    snapped: bool


def find_axes(samples: Sequence[WrenchSample]) -> Presses:
    """
    Return axes and sign of the sensor: only one order of the presses is right-handed.

    Parameters
    ----------
    samples : sequence of WrenchSample
        Of a peg that hangs still and is pushed by hand along PUSHES, one after another.

    Raises
    ------
    PegOnHoleError
        There are not three presses, or they are not at right angles.

    """
    pressed = np.array([press.force for press in pressed_stretches(samples)]).reshape(-1, 3)
    if len(pressed) != 3:
        raise PegOnHoleError(
            "push the still peg up at its lower end, then along its x, then along its y, with "
            f"{HAND_PRESS.least_force:g} N and more for {HAND_PRESS.shortest:g} s and more, and a "
            f"pause between: the recording has {len(pressed)} such presses, not 3"
        )
    forces = np.linalg.norm(pressed, axis=1)
    U = (pressed / forces[:, None]).T
    # What the sensor's robot side exerts on the peg is the opposite of what the hand does.
    sign = float(np.sign(np.linalg.det(U @ PUSHES.T)))
    left, _, right = np.linalg.svd(PUSHES @ (sign * U).T)
    R_PS = left @ np.diag([1.0, 1.0, np.linalg.det(left @ right)]) @ right
    off = np.clip(np.sum(PUSHES * (R_PS @ (sign * U)), axis=0), -1.0, 1.0)
    missed = degrees(float(np.sqrt(np.mean(np.arccos(off) ** 2))))
    if missed > HAND_PRESS.most_miss:
        raise PegOnHoleError(
            "push up at the lower end first, then along x, then along y of the peg frame: the "
            f"presses are {missed:.0f} degrees off three right angles"
        )
    near = min(quarter_turns(), key=lambda turn: -np.trace(R_PS.T @ turn))
    turned = _degrees_between(R_PS, near)
    snaps = turned <= HAND_PRESS.snap
    return Presses(
        "robot" if sign > 0.0 else "peg",
        rpy_of(near if snaps else R_PS),
        rpy_of(R_PS),
        turned if snaps else 0.0,
        missed,
        forces,
        snaps,
    )


class Press(NamedTuple):
    """
    One press, as long as it is firm.

    Attributes
    ----------
    begin_ns, end_ns : int
        [ns]
    force : ndarray, shape (3,)
        Mean change of the force, in the axes of the numbers [N].

    """

    begin_ns: int
    end_ns: int
    force: np.ndarray


def pressed_stretches(samples: Sequence[WrenchSample]) -> list[Press]:
    """Return the presses of a recording in which most of the time nothing presses."""
    t_ns = np.array([sample.t_ns for sample in samples], np.int64)
    t = t_ns * 1e-9
    force = np.array([sample.force for sample in samples], float).reshape(-1, 3)
    if len(t) < 2:
        return []
    change = force - np.median(force, axis=0)
    width = max(1, round(HAND_PRESS.averaged * (len(t) - 1) / max(t[-1] - t[0], 1e-9)))
    box = np.ones(width) / width
    change = np.stack([np.convolve(column, box, "same") for column in change.T], axis=1)
    size, found, begun = np.linalg.norm(change, axis=1), [], None
    least = HAND_PRESS.least_force
    for i, value in enumerate([*size, 0.0]):
        if begun is None and value > least:
            begun = i
        elif begun is not None and value < HAND_PRESS.released_share * least:
            if t[i - 1] - t[begun] >= HAND_PRESS.shortest:
                # Where the hand is firm its direction is.
                part = slice(begun, i)
                firm = begun + np.flatnonzero(
                    size[part] > HAND_PRESS.firm_share * size[part].max()
                )
                mean = change[firm].mean(axis=0)
                found.append(Press(int(t_ns[firm[0]]), int(t_ns[firm[-1]]), mean))
            begun = None
    return found


class Axes(NamedTuple):
    """
    Whose axes the numbers are in.

    Attributes
    ----------
    axes : str
        As `wrench.axes` has them.
    off : float
        Between these and what the hand had [degrees].
    alike : str
        Others that look the same in the pose of the presses; empty: none.

    """

    axes: str
    off: float
    alike: str


def held_orientation(measured: Sequence[AngleMeasurement]) -> np.ndarray | None:
    """Return the mean orientation of a peg that is held still, R_HP (3, 3), or None of none."""
    if not measured:
        return None
    left, _, right = np.linalg.svd(np.mean([peg_axes(each.q) for each in measured], axis=0))
    return left @ np.diag([1.0, 1.0, np.linalg.det(left @ right)]) @ right


def axes_of(pressed: Presses, configuration: Configuration, R_HP: np.ndarray | None) -> Axes:
    """
    Return whose axes the numbers are in: those that are stated, unless others fit and they do not.

    Parameters
    ----------
    pressed : Presses
    configuration : Configuration
    R_HP : ndarray, shape (3, 3), or None
        How the peg was held; without it the axes are the sensor's.

    """
    wrench, R_PN = configuration.wrench, rotation_from_rpy(pressed.found)
    off = {"sensor": pressed.turned}
    fits = ["sensor"] if pressed.snapped else []
    for name, R_PL in _axes_of_links(configuration, R_HP):
        off[name] = _degrees_between(R_PN, R_PL)
        if off[name] <= HAND_PRESS.snap:
            fits.append(name)
    nearest = min(fits, key=lambda name: (name != "sensor", off[name]), default="sensor")
    axes = wrench.axes if wrench.axes in fits else nearest
    # A link and another that is not turned against it are one.
    others = [name for name in fits if off[name] != off[axes]]
    return Axes(axes, off[axes], others[0] if others else "")


def _axes_of_links(configuration: Configuration, R_HP: np.ndarray | None):
    """Yield links in whose axes numbers may be, and their axes in the peg frame."""
    wrench = configuration.wrench
    if wrench.axes != "sensor" and wrench.base_rpy is None:
        # One that the tip carries: the sensor's axes are those of it.
        yield wrench.axes, rotation_from_rpy(wrench.sensor_rpy)
    if R_HP is not None:
        R_PR = R_HP.T @ rotation_from_rpy(configuration.joints.hole_rpy).T
        for link in wrench.base_links:
            yield link.name, R_PR @ rotation_from_rpy(link.rpy)


def _degrees_between(A: np.ndarray, B: np.ndarray) -> float:
    return degrees(float(np.arccos(np.clip(0.5 * (np.trace(A.T @ B) - 1.0), -1.0, 1.0))))
