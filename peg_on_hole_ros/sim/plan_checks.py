"""What the parts of a plan ask of one another before anything is simulated."""

from __future__ import annotations

from math import pi
from typing import TYPE_CHECKING

import numpy as np

from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.records import ANGLES

if TYPE_CHECKING:
    from peg_on_hole_ros.sim.plan import Plan

# Beyond, no peg is turned, and degrees have been taken for radians [rad/s].
MOST_RATE = 100.0
# What rounding leaves of a path that ends upright [rad].
_ROUNDING = 1e-9


def check_together(plan: Plan) -> None:
    """
    Refuse a plan whose parts do not fit together.

    Parameters
    ----------
    plan : Plan

    Raises
    ------
    PegOnHoleError

    """
    gamma = plan.start.angles[0]  # type: ignore[index]
    if not 0 < gamma < pi / 2:
        raise PegOnHoleError(
            f"simulation.start.angles[0] = {gamma:g} rad, the tilt gamma, is not between 0 and "
            f"{pi / 2:.6g} rad, both excluded: angles are in radians, and a peg that leans to the "
            "other side has psi half a turn further"
        )
    if plan.wrench_rate % plan.joint_rate:
        raise PegOnHoleError(
            f"simulation.wrench_rate = {plan.wrench_rate} Hz is not a multiple of "
            f"joint_rate = {plan.joint_rate} Hz: the joints are sampled with every n-th wrench"
        )
    joints = plan.configuration.joints
    if joints.source != "peg":
        raise PegOnHoleError(
            "joints.source = robot is not simulated: the simulated joint states are the peg's own "
            "angles; set joints.source to peg"
        )
    duration = sum(phase.duration for phase in plan.phases)
    if plan.lead_in >= duration:
        raise PegOnHoleError(
            f"simulation.lead_in = {plan.lead_in:g} s leaves nothing of the {duration:g} s that "
            "the phases last"
        )
    before = plan.phases[0].kind
    for phase in plan.phases:
        if phase.kind == "two_point" and before == "free":
            raise PegOnHoleError(
                f"simulation.phases.{phase.name}: two_point does not follow free; the hole is "
                "entered through three-point contact"
            )
        if before == "two_point" and phase.kind != "two_point":
            raise PegOnHoleError(
                f"simulation.phases.{phase.name}: {phase.kind} does not follow two_point; in the "
                "hole the simulation ends"
            )
        if before == "parted" and phase.kind != "parted":
            raise PegOnHoleError(
                f"simulation.phases.{phase.name}: {phase.kind} does not follow parted; with a "
                "contact open the simulation ends"
            )
        if before == "insert" and phase.kind != "insert":
            raise PegOnHoleError(
                f"simulation.phases.{phase.name}: {phase.kind} does not follow insert; in the "
                "hole the simulation ends"
            )
        _check_place(phase, plan.configuration.scene.peg_height)
        if phase.load and phase.kind != "two_point":
            raise PegOnHoleError(
                f"simulation.phases.{phase.name}.load is for two_point; elsewhere the reactions "
                "come out of the motion"
            )
        if phase.friction is not None and phase.kind not in ("contact", "two_point", "insert"):
            raise PegOnHoleError(
                f"simulation.phases.{phase.name}.friction is for contact, two_point and insert; "
                f"in {phase.kind} contacts open: set it in the phase before"
            )
        before = phase.kind


def _check_place(phase, height):
    where = f"simulation.phases.{phase.name}"
    if phase.kind != "insert":
        for name in ("depth", "depth_rate", "place"):
            if getattr(phase, name):
                raise PegOnHoleError(
                    f"{where}.{name} is for insert; in {phase.kind} the peg's place follows from "
                    "angles and offset"
                )
        return
    if phase.offset is not None:
        raise PegOnHoleError(
            f"{where}.offset is not for insert: in the hole state place and depth of the lower "
            "end's centre"
        )
    if phase.depth is not None and not phase.depth < height:
        raise PegOnHoleError(
            f"{where}.depth = {phase.depth:g} m is not below scene.peg_height = {height:g} m: "
            "the whole peg would be in the hole"
        )


def check_motion(plan: Plan, knots: np.ndarray, coefficients: np.ndarray) -> None:
    """
    Refuse tilts and rates on the way that no peg on a hole can have.

    Below gamma0 a command in contact is fine: the run ends there, or goes on in the hole.

    Parameters
    ----------
    plan : Plan
    knots : ndarray, shape (n + 1,)
        Begin of each phase, and end of the last [s].
    coefficients : ndarray, shape (n, channels, 6)
        Of the commanded motion.

    Raises
    ------
    PegOnHoleError

    """
    gamma0, before = plan.configuration.scene.gamma0, None
    for phase, duration, pieces in zip(plan.phases, np.diff(knots), coefficients):
        where = f"simulation.phases.{phase.name}"
        if phase.angles is not None and not 0 <= phase.angles[0] < pi / 2:
            raise PegOnHoleError(f"{where}.angles[0] = {phase.angles[0]:g} rad, {_tilt()}")
        powers = np.linspace(0, duration, 65)[:, None] ** np.arange(6)
        angles = powers @ pieces[:3].T
        rates = powers[:, :5] @ (pieces[:3, 1:] * np.arange(1, 6)).T
        touches = phase.kind not in ("free", "insert")
        if before in (None, "free") and touches and angles[0, 0] <= gamma0:
            raise PegOnHoleError(
                f"{where} begins in contact at gamma = {angles[0, 0]:g} rad, but a peg rests on "
                f"three contacts above gamma0 = {gamma0:.6g} rad only, which follows from the two "
                "diameters; begin at a larger tilt, and go on with two_point"
            )
        lowest = 0 if phase.kind in ("free", "two_point") else -pi / 2
        for gamma in (angles[:, 0].min(), angles[:, 0].max()):
            if not lowest - _ROUNDING <= gamma < pi / 2:
                raise PegOnHoleError(
                    f"{where} leads through gamma = {gamma:.4g} rad, {_tilt()}; without angles a "
                    "phase goes on at the mean of the rates at its ends"
                )
        fastest = np.abs(rates).max(axis=0)
        name, rate = ANGLES[fastest.argmax()], fastest.max()
        if rate > MOST_RATE:
            raise PegOnHoleError(
                f"{where} turns {name} at up to {rate:.4g} rad/s, which is not within "
                f"{MOST_RATE:g} rad/s: it has {duration:g} s for it; give it longer, or a shorter "
                "way (angles are in radians)"
            )
        before = phase.kind


def _tilt():
    return (
        f"which is not a tilt from 0 to below {pi / 2:.6g} rad: angles are in radians, and a peg "
        "that leans to the other side has psi half a turn further"
    )
