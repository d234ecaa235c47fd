"""A cell's own motion, simulated: the one that is planned, or that of a recording."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from peg_on_hole_ros.config.options import Configuration, JointInput, WrenchInput
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.mechanics.planning.motion import ClosingMotion
from peg_on_hole_ros.mechanics.planning.search import plan_motion
from peg_on_hole_ros.sim.plan import plan_from_tree
from peg_on_hole_ros.sim.truth import Truth, integrate

# Simulated before the recording, in which the peg comes to lie on its contacts [s].
CLOSING_LEAD_IN = 0.15
# A plan is led on through gamma0 by so much tilt [rad], and loads there [N].
BEYOND, WALL_LOADS = 0.02, (30.0, 30.0)
# A recording is followed in pieces of [s].
PIECE = 0.02
# A motion on three contacts is worth it from so long on, and of a longer one the end is taken [s].
SHORTEST, LONGEST = 0.1, 2.0
# Orientations come at most so often [Hz].
MOST_ORIENTATIONS = 500
# Loads that a robot may have that the simulated holder is not to end a run at [N], [N m].
_STRONG: dict[str, Any] = {"force_limit": 1e5, "torque_limit": 1e4}


class Recorded(NamedTuple):
    """
    What a recording shows of a stretch on three contacts.

    Attributes
    ----------
    t : ndarray, shape (n,)
        [s]
    angles, rates : ndarray, shape (n, 3)
        gamma, psi, phi [rad], of which psi and phi unwrapped; [rad/s].
    push : ndarray, shape (n, 3)
        What the peg presses on its contacts with, along h, e, z [N].

    """

    t: np.ndarray
    angles: np.ndarray
    rates: np.ndarray
    push: np.ndarray


def simulated_cell(configuration: Configuration) -> Configuration:
    """
    Return a cell as it is simulated: a tared sensor in its own axes, angles with its noise.

    Joints that are noisy by s turn the peg by sqrt(n / 3) s about any axis: each of n stands
    somewhere, and turns it about its own.
    """
    wrench, joints = configuration.wrench, configuration.joints
    arm = np.sqrt(len(joints.names) / 3.0) if joints.source == "robot" else 1.0
    return replace(
        configuration,
        wrench=WrenchInput(
            sensor_xyz=wrench.sensor_xyz, sensor_rpy=wrench.sensor_rpy,
            force_stddev=wrench.force_stddev, torque_stddev=wrench.torque_stddev,
            payload_mass=wrench.payload_mass, payload_com=wrench.payload_com,
        ),
        joints=JointInput(position_stddev=float(arm) * joints.position_stddev),
    )  # fmt: skip


def planned_motion(configuration: Configuration, wrench_rate: int) -> Truth:
    """
    Return the simulated motion that `peg-on-hole plan` finds for a cell.

    Parameters
    ----------
    configuration : Configuration
    wrench_rate : int
        [Hz]

    Raises
    ------
    PegOnHoleError
        No motion keeps the cell's limits.

    """
    scene, cell = configuration.scene, configuration.plan
    plan = plan_motion(scene, cell, configuration.monitor.max_normal)
    if not plan.possible:
        raise PegOnHoleError(
            "give a recording with --bag, or a file with a section 'simulation:': no motion keeps "
            "the limits of this cell, so methods cannot be compared on one (peg-on-hole plan "
            "names the limits, and changes that make a motion possible)"
        )
    return led_through(configuration, plan.motion, wrench_rate)


def led_through(configuration: Configuration, motion: ClosingMotion, wrench_rate: int) -> Truth:
    """Return a planned motion as a holder leads it, through gamma0; see `planned_motion`."""
    cell = configuration.plan
    first, *stages = motion.stages
    # The ramp from rest has one direction, that of the rates it comes to: it is left out.
    rates = np.array(first.rates)
    offset = [float(x / cell.stiffness) for x in cell.press]
    phases: dict[str, Any] = {}
    tilt = motion.start_tilt - CLOSING_LEAD_IN * rates[0]
    start = [float(tilt), 0.0, 0.0]
    for k, stage in enumerate(stages):
        duration = stage.duration if k else (stage.tilt - tilt) / rates[0]
        phases[stage.name + str(k)] = {
            "kind": "contact", "duration": max(float(duration), 1e-3),
            "rates": list(stage.rates), "offset": offset,
        }  # fmt: skip
        tilt = stage.tilt
    last = stages[-1].rates
    phases["through"] = {
        "kind": "two_point", "duration": BEYOND / -last[0], "rates": list(last),
        "load": list(WALL_LOADS),
    }  # fmt: skip
    return _integrated(configuration, start, rates.tolist(), offset, phases, wrench_rate)


def recorded_motion(configuration: Configuration, recorded: Recorded, wrench_rate: int) -> Truth:
    """
    Return a simulated motion that follows a recorded one, as the holder of `plan` leads it.

    Raises
    ------
    PegOnHoleError
        It is too short, or does not keep its contacts in simulation.

    """
    stiffness = configuration.plan.stiffness
    count = int((recorded.t[-1] - recorded.t[0]) / PIECE)
    at = recorded.t[0] + PIECE * np.arange(count + 1)
    columns = np.hstack([recorded.angles, recorded.rates, recorded.push / stiffness])
    knots = np.column_stack([np.interp(at, recorded.t, column) for column in columns.T])
    # The commanded pose is never nearer to gamma0 than three points are.
    knots[:, 0] = np.maximum(knots[:, 0], 1.001 * configuration.scene.gamma0)
    phases = {
        f"piece{k}": {
            "kind": "contact", "duration": PIECE, "angles": knot[:3].tolist(),
            "rates": knot[3:6].tolist(), "offset": knot[6:].tolist(),
        }
        for k, knot in enumerate(knots[1:])
    }  # fmt: skip
    first = knots[0]
    return _integrated(
        configuration, first[:3].tolist(), first[3:6].tolist(), first[6:].tolist(), phases,
        wrench_rate,
    )  # fmt: skip


def _integrated(
    configuration: Configuration,
    start: Sequence[float],
    rates: Sequence[float],
    offset: Sequence[float],
    phases: dict[str, Any],
    wrench_rate: int,
) -> Truth:
    cell = configuration.plan
    tree = {
        "lead_in": min(CLOSING_LEAD_IN, 0.9 * sum(phase["duration"] for phase in phases.values())),
        "wrench_rate": wrench_rate,
        "joint_rate": joint_rate_of(wrench_rate),
        "holder": {
            "stiffness": cell.stiffness,
            "rotational_stiffness": cell.rotational_stiffness,
            "damping_ratio": cell.damping_ratio,
            **_STRONG,
        },
        "start": {"angles": list(start), "rates": list(rates), "offset": list(offset)},
        "phases": phases,
    }
    # The holder takes hold where the cell says, wherever the sensor is.
    held = replace(
        configuration,
        wrench=replace(configuration.wrench, sensor_xyz=(0.0, 0.0, cell.grip_height)),
    )
    truth = integrate(plan_from_tree(held, tree))
    truth = replace(truth, plan=replace(truth.plan, configuration=configuration))
    if on_three(truth) < SHORTEST * wrench_rate:
        raise PegOnHoleError(
            f"in simulation the motion does not keep three contacts for {SHORTEST:g} s "
            f"({truth.ended_by}), so there is nothing to compare; see plan.stiffness, plan.press "
            "and scene.friction"
        )
    return _its_end(truth)


def _its_end(truth: Truth) -> Truth:
    """Return a motion from LONGEST before it leaves three contacts on, at stamps from zero on."""
    every = truth.plan.wrench_rate // truth.plan.joint_rate
    first = on_three(truth) - round(LONGEST * truth.plan.wrench_rate)
    # The first wrench comes with an orientation.
    first = max(first, 0) // every * every
    n = len(truth.t_ns)
    rows = {
        name: value[first:]
        for name, value in vars(truth).items()
        if isinstance(value, np.ndarray) and len(value) == n
    }
    rows["t_ns"] = rows["t_ns"] - truth.t_ns[first]
    return replace(truth, **rows)  # type: ignore[arg-type]


def on_three(truth: Truth) -> int:
    """Return how many samples a motion keeps three contacts for, from its begin on."""
    good = (truth.mode == "three_point") & truth.known
    return len(good) if good.all() else int(np.argmin(good))


def joint_rate_of(wrench_rate: int) -> int:
    """Return how often orientations come with a wrench [Hz]: each with one, at most 500."""
    every = next(k for k in range(1, wrench_rate + 1)
                 if wrench_rate % k == 0 and wrench_rate // k <= MOST_ORIENTATIONS)  # fmt: skip
    return wrench_rate // every
