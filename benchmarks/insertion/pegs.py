"""Insertions of pegs of other sizes, clearances and frictions, from three contacts on."""

from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.config.options import Configuration, WrenchInput
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.sim.plan import plan_from_tree


class Peg(NamedTuple):
    """
    A peg, its holder and its sensor.

    Attributes
    ----------
    diameter, clearance, height : float
        [m]
    mass, friction : float
        [kg], [-]
    force, torque : float
        Standard deviation of the sensor's noise [N], [N m].
    turning : float
        Stiffness of the holder [N m/rad].

    """

    diameter: float
    clearance: float
    height: float
    mass: float
    friction: float
    force: float
    torque: float
    turning: float


PEGS = {
    "10_mm": Peg(0.010, 2e-5, 0.030, 0.1, 0.15, 0.05, 1e-3, 20.0),
    "20_mm": Peg(0.020, 8e-5, 0.040, 0.2, 0.30, 0.1, 2e-3, 40.0),
    "50_mm": Peg(0.050, 1e-4, 0.070, 0.5, 0.20, 0.2, 5e-3, 100.0),
}
# By how much the contacts of each model of `pinocchio_traces.py` give [m/N].
COMPLIANCES = {"metal": 2e-8, "soft": 1e-7}
# Of the rows of `pinocchio_traces.py`: angles [rad], depth [m], force [N], moment [N m], normal
# forces [N]; what is stored are differences of rows, in these.
UNITS = np.repeat([1e-9, 1e-9, 1e-4, 1e-6, 1e-3], [3, 1, 3, 3, 3])
# Of the holder [N/m], and how far it presses beyond where the peg touches [m].
STIFFNESS, PRESS = 1e4, 1e-3
# Tilts at the begin, at the end of the closing and of each part down the hole, over gamma0.
TILTS = 1.35, 1.02, 0.5, 0.1
# Times of the three parts [s]; how fast it turns about its axis [rad/s].
TIMES, SLIP = (0.25, 0.2, 0.3), 1.5


def plan_of(name: str):
    """Return the plan of a peg that closes, passes the transition, and slides down the hole."""
    peg = PEGS[name]
    scene = Scene(
        hole_diameter=peg.diameter,
        peg_diameter=peg.diameter - peg.clearance,
        peg_height=peg.height,
        peg_mass=peg.mass,
        friction=peg.friction,
    )
    configuration = Configuration(
        scene=scene,
        wrench=WrenchInput(
            sensor_xyz=(0.0, 0.0, peg.height), force_stddev=peg.force, torque_stddev=peg.torque
        ),
    )
    begin, closed, in_hole, deep = (share * scene.gamma0 for share in TILTS)
    closing = (closed - begin) / TIMES[0]
    turned = [SLIP * sum(TIMES[: k + 1]) for k in range(3)]
    phases = {
        "close": {"duration": TIMES[0], "rates": [closing, 0.0, SLIP]},
        "through": {
            "duration": TIMES[1],
            "angles": [in_hole, 0.0, turned[1]],
            "rates": [0.0, 0.0, SLIP],
            "depth": in_the_hole(peg, in_hole) + PRESS,
        },
        "down": {
            "duration": TIMES[2],
            "angles": [deep, 0.0, turned[2]],
            "rates": [0.0, 0.0, SLIP],
            "depth": in_the_hole(peg, deep) + 2 * PRESS,
        },
    }
    tree = {
        "holder": {
            "stiffness": STIFFNESS,
            "rotational_stiffness": peg.turning,
            "force_limit": 1e3,
        },
        "start": {
            "angles": [begin, 0.0, 0.0],
            "rates": [closing, 0.0, SLIP],
            "offset": [0.0, 0.0, -PRESS],
        },
        "phases": {name: {"kind": "insert", **phase} for name, phase in phases.items()},
    }
    return plan_from_tree(configuration, tree)


def in_the_hole(peg: Peg, tilt: float) -> float:
    """Return how deep a peg is that touches on two points [m], for a small tilt [rad]."""
    return (peg.clearance + (peg.diameter - peg.clearance) * tilt**2 / 2) / tilt
