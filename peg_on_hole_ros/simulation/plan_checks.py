"""What the parts of a plan ask of one another before anything is simulated."""

from math import pi

from peg_on_hole_ros.errors import PegOnHoleError


def check_together(plan) -> None:
    """
    Refuse a plan whose parts do not fit together.

    Parameters
    ----------
    plan : Plan

    Raises
    ------
    PegOnHoleError

    """
    gamma = plan.start.angles[0]
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
        if phase.load and phase.kind != "two_point":
            raise PegOnHoleError(
                f"simulation.phases.{phase.name}.load is for two_point; elsewhere the reactions "
                "come out of the motion"
            )
        if phase.friction is not None and phase.kind not in ("contact", "two_point"):
            raise PegOnHoleError(
                f"simulation.phases.{phase.name}.friction is for contact and two_point; in "
                f"{phase.kind} contacts let go: set it in the phase before"
            )
        before = phase.kind
