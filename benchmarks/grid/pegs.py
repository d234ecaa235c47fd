"""Pegs and sensors unlike those that all thresholds were chosen with: size, mass, rate, noise."""

from functools import cache
from typing import NamedTuple

from peg_on_hole_ros.config.options import Configuration, JointInput, WrenchInput
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.sim.plan import plan_from_tree
from peg_on_hole_ros.sim.truth import integrate


class Peg(NamedTuple):
    """Diameter and clearance [m], mass [kg], noise [N], [N m], stiffness [N/m], [N m/rad]."""

    diameter: float
    clearance: float
    mass: float
    force: float
    torque: float
    stiffness: float
    rotational: float
    tilt: float = 0.19


PEGS = {
    "4 mm": Peg(4e-3, 8e-6, 0.2, 0.05, 1e-3, 5e3, 50.0),
    "10 mm": Peg(0.01, 2e-5, 0.2, 0.05, 1e-3, 5e3, 100.0),
    "50 mm": Peg(0.05, 1e-4, 0.5, 0.2, 5e-3, 2e4, 2e3),
    "150 mm": Peg(0.15, 3e-4, 8.0, 2.0, 0.1, 1e5, 2e4),
}


@cache
def closing(name, wrench_rate=1000, joint_rate=500, rate=-0.05, duration=0.6):
    """Return a peg that closes and turns about its axis by 2 rad/s, friction uncertain by 0.05."""
    peg = PEGS[name]
    scene = Scene(
        hole_diameter=peg.diameter,
        peg_diameter=peg.diameter - peg.clearance,
        peg_height=1.4 * peg.diameter,
        peg_mass=peg.mass,
    )
    configuration = Configuration(
        scene=scene,
        wrench=WrenchInput(
            sensor_xyz=(0.0, 0.0, 1.4 * peg.diameter),
            force_stddev=peg.force,
            torque_stddev=peg.torque,
        ),
        joints=JointInput(),
    )
    tree = {
        "lead_in": 0.05,
        "wrench_rate": wrench_rate,
        "joint_rate": joint_rate,
        "holder": {
            "stiffness": peg.stiffness,
            "rotational_stiffness": peg.rotational,
            "force_limit": 1000.0,
            "torque_limit": 200.0,
        },
        "start": {
            "angles": [peg.tilt, 0.0, 0.0],
            "rates": [rate, 0.0, 2.0],
            "offset": [0.0, 0.0, -0.001],
        },
        "phases": {"close": {"kind": "contact", "duration": duration, "rates": [rate, 0.0, 2.0]}},
    }
    return integrate(plan_from_tree(configuration, tree))
