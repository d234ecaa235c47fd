"""Simulated insertions that several tests look at, each integrated once a process."""

from functools import cache

from peg_on_hole_ros.config.options import Configuration, WrenchInput
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.sim.plan import plan_from_tree
from peg_on_hole_ros.sim.truth import integrate


@cache
def inserted(kind, clearance=1e-4, press=1e-3):
    """A peg is set down, goes in on two points, and is jammed by a side load or goes on."""
    scene = Scene(0.03, 0.03 - clearance, peg_height=0.055, friction=0.25)
    told = Configuration(scene=scene, wrench=WrenchInput(sensor_xyz=(0.0, 0.0, 0.065)))
    gamma0, D = scene.gamma0, scene.hole_diameter
    insert = {"kind": "insert", "rates": [0.0, 0.0, 0.0]}

    def at(share):
        return [clearance / (share * D), 0.0, 0.0]

    phases = {
        "close": {"kind": "insert", "duration": 0.1, "rates": [-0.2, 0.0, 1.5]},
        "through": {**insert, "duration": 0.2, "angles": at(0.2), "depth": 0.2 * D},
        "go_in": {**insert, "duration": 0.4, "angles": at(0.45), "depth": 0.45 * D},
    }
    if kind == "goes_on":
        phases["go_in"] |= {"depth_rate": 0.03}
        phases["down"] = {**insert, "duration": 0.4, "angles": at(0.9), "depth": 0.85 * D}
    else:
        phases["aside"] = {**insert, "duration": 0.15, "angles": at(0.45), "place": [-0.002, 0.0]}
        phases["push"] = {**phases["aside"], "depth": 0.45 * D + 0.0015}
        phases["pushing"] = {**phases["push"], "duration": 0.3}
    tree = {
        "lead_in": 0.05,
        "holder": {"stiffness": 1e4, "rotational_stiffness": 80.0},
        "start": {
            "angles": [gamma0 + 0.03, 0.0, 0.0],
            "rates": [-0.2, 0.0, 1.5],
            "offset": [0.0, 0.0, -press],
        },
        "phases": phases,
    }
    return integrate(plan_from_tree(told, tree))
