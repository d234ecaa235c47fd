"""The published grid: scenes, motions, noise and start errors, and the truth of each motion."""

import itertools
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.config.options import Configuration, JointInput, WrenchInput
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.sim.plan import plan_from_tree
from peg_on_hole_ros.sim.truth import integrate

CLEARANCES = (2e-5, 1e-4, 5e-4, 2e-3)  # [m]
FRICTIONS = (0.05, 0.2, 0.5)
SPEEDS = (0.01, 0.16, 1.0)  # closing [rad/s]
MOTIONS = ("align", "slip", "reversals")
# Never looked at while the filter is tuned.
HELD_OUT = ("helix", "weave")
# Force [N], torque [N m], orientation [rad].
NOISE = {
    "low": (0.05, 0.001, 2e-5),
    "nominal": (0.2, 0.005, 1e-4),
    "high": (1.0, 0.02, 5e-4),
}
LEAD_IN = 0.05
# Friction is Coulomb's to 0.6 % at 50 um/s, the slowest slip of the grid [m/s].
SLIP_VELOCITY_SCALE = 5e-6
# Commanded into the hole [m], from gentle to firm: the first that keeps the motion going is taken.
PRESSES = ((0.0, 0.0, -0.001), (-0.0005, 0.0, -0.0015), (-0.001, 0.0, -0.003))
ENOUGH = 0.7
SHORTEST = 60  # samples
# Pushed without slip, K opens at a large tilt: then the motion begins nearer to gamma0.
SHARES = (1.0, 0.5, 0.25)


class Motion(NamedTuple):
    """A scene and how the peg moves in it; its noise is chosen when it is measured."""

    clearance: float
    friction: float
    speed: float
    name: str

    def __str__(self):
        """Return a name for files and tables."""
        c, f, v, name = self
        return f"{name}_c{c * 1e3:g}mm_f{f:g}_v{v:g}"


FULL = tuple(Motion(*m) for m in itertools.product(CLEARANCES, FRICTIONS, SPEEDS, MOTIONS))
FULL_HELD_OUT = tuple(
    Motion(*m) for m in itertools.product(CLEARANCES, FRICTIONS, SPEEDS, HELD_OUT)
)
QUICK = (
    *(Motion(1e-4, 0.2, 0.16, name) for name in (*MOTIONS, *HELD_OUT)),
    Motion(2e-5, 0.2, 0.16, "slip"),
    Motion(2e-3, 0.2, 0.16, "slip"),
    Motion(5e-4, 0.05, 0.16, "reversals"),
    Motion(5e-4, 0.5, 0.16, "slip"),
    Motion(1e-4, 0.2, 0.01, "slip"),
    Motion(1e-4, 0.2, 1.0, "slip"),
    Motion(5e-4, 0.2, 1.0, "reversals"),
)
SMALLEST = (Motion(1e-4, 0.2, 0.16, "slip"), Motion(5e-4, 0.2, 0.16, "reversals"))


def legs(motion: Motion) -> tuple[list, float]:
    """
    Return the rates commanded at the begin and at the end of each leg, and their duration.

    Returns
    -------
    rates : list of tuple of 3 float
        gamma', psi', phi' [rad/s].
    duration : float
        Of all legs, after the lead-in [s].

    """
    v = motion.speed
    # Turns of the peg that go with the paper's closing of 0.16 rad/s and slip of 2 rad/s.
    w = min(12.5 * v, 5.0)
    duration = float(np.clip(0.2 / v, 0.25, 1.0))
    if motion.name == "align":
        return [(-v, 0, 0), (-v, 0, 0)], duration
    if motion.name == "slip":
        return [(-v, 0, w), (-v, 0, w)], duration
    if motion.name == "bend":
        # No cell of the grid: for tuning, rates that change slowly all the time.
        return [(-v, 0.2 * w, 0.9 * w), (-0.8 * v, 0.5 * w, 0.55 * w)], duration
    if motion.name == "helix":
        return [(-v, 0.5 * w, 0.4 * w), (-0.6 * v, 0.2 * w, 1.2 * w)], duration
    w, duration = min(w, 2.5), max(duration, 0.45)
    if motion.name == "sway":
        # Nor this: for tuning, rates that turn back and forth.
        return [
            (-v, 0.4 * w, 0.7 * w), (-0.7 * v, -0.4 * w, 0.3 * w), (-0.9 * v, 0.4 * w, -0.6 * w),
        ], duration  # fmt: skip
    if motion.name == "turn":
        # Nor this: for tuning, a peg that turns round once, and quickly.
        return [(-v, 0.25 * w, 0.8 * w), (-v, -0.25 * w, -0.8 * w)], 0.25
    if motion.name == "reversals":
        return [
            (-v, 0.3 * w, w), (-v / 2, -0.3 * w, -w), (v / 5, 0.3 * w, w), (-v, 0.3 * w, -w),
        ], duration  # fmt: skip
    return [(-v, 0.5 * w, 0.5 * w), (-v, -0.5 * w, 0.5 * w), (v / 5, 0, -0.5 * w)], duration


def plan_of(motion: Motion, press, share: float = 1.0):
    """Return the plan that ends near gamma0, most of it outside its neighbourhood."""
    rates, duration = legs(motion)
    duration = round(duration * share, 3)
    leg = duration / (len(rates) - 1)
    D = 0.050
    scene = Scene(hole_diameter=D, peg_diameter=D - motion.clearance, friction=motion.friction)
    travel = leg * sum((a[0] + b[0]) / 2 for a, b in itertools.pairwise(rates))
    last = max(1.03 * scene.gamma0, 1.15 * scene.gamma0 + 0.3 * travel)
    start = [last - travel - LEAD_IN * rates[0][0], 0.0, 0.0]
    tree = {
        "lead_in": LEAD_IN,
        "slip_velocity_scale": SLIP_VELOCITY_SCALE,
        "holder": {"force_limit": 2000.0, "torque_limit": 200.0},
        "start": {"angles": start, "rates": list(rates[0]), "offset": list(press)},
        "phases": {"lead": {"kind": "contact", "duration": LEAD_IN, "rates": list(rates[0])}},
    }
    for i, rate in enumerate(rates[1:]):
        tree["phases"][f"leg{i}"] = {"kind": "contact", "duration": leg, "rates": list(rate)}
    return plan_from_tree(Configuration(scene=scene), tree), duration


def truth_of(motion: Motion):
    """
    Return the motion's truth as far as the rigid peg keeps three contacts, and how that ended.

    Returns
    -------
    truth : Truth or None
        None: no press keeps three contacts at all.
    end : str
        `complete`, or what cut the motion short.

    """
    best, best_end, kept_share = None, "no three-point contact at the begin", 1
    for share, press in itertools.product(SHARES, PRESSES):
        plan, duration = plan_of(motion, press, share)
        try:
            truth = integrate(plan)
        except PegOnHoleError as error:
            best_end = str(error) if best is None else best_end
            continue
        count = touching(truth)
        if best is None or count > len(best.t_ns):
            best = first_samples(truth, count)
            best_end, kept_share, whole = truth.ended_by, share, duration
        if count >= ENOUGH * duration * plan.wrench_rate:
            break
    if best is None or len(best.t_ns) < SHORTEST:
        return None, best_end
    complete = len(best.t_ns) >= whole * best.plan.wrench_rate
    nearer = "" if kept_share == 1 else f", {kept_share:g} of it"
    return best, ("complete" if complete else best_end) + nearer


def touching(truth) -> int:
    """Return how many samples from the first on keep three contacts with known reactions."""
    good = (truth.mode == "three_point") & truth.known
    return len(good) if good.all() else int(np.argmin(good))


def first_samples(truth, count):
    """Return a truth of which only the first samples are left."""
    names = (
        "t_ns", "q", "rates", "acceleration", "position", "centre", "normal", "slip_speed",
        "closed", "known", "contact_point", "contact_force", "force", "moment", "mode", "phase",
    )  # fmt: skip
    return replace(truth, **{name: getattr(truth, name)[:count] for name in names})


def with_noise(truth, level: str, friction_stddev: float | None = None):
    """Return the truth as it is measured, and the estimator configured, at a level of NOISE."""
    force, torque, angle = NOISE[level]
    scene = truth.plan.configuration.scene
    if friction_stddev is not None:
        scene = replace(scene, friction_stddev=friction_stddev)
    configuration = replace(
        truth.plan.configuration,
        scene=scene,
        wrench=WrenchInput(force_stddev=force, torque_stddev=torque),
        joints=JointInput(position_stddev=angle),
    )
    return replace(truth, plan=replace(truth.plan, configuration=configuration))
