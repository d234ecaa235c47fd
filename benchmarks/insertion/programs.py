"""The insertions that are compared with another engine: peg, holder and its program."""

from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.sim.plan import plan_from_tree

SCENE = Scene(hole_diameter=0.050, peg_diameter=0.0496)
HOLDER = {"stiffness": 1e4, "rotational_stiffness": 100.0, "force_limit": 1e3}
# On two points, 20 mm in the hole.
START = {"angles": [0.02, 0.0, 0.0], "rates": [0.0, 0.0, 0.0]}


def _insert(duration, **more):
    return {"kind": "insert", "duration": duration, **more}


PROGRAMS = {
    # Tilted on two points, down to a diameter, turning.
    "slides": {
        "down": _insert(0.25, angles=[0.016, 0.0, 0.3], rates=[0.0, 0.0, 1.0], depth=0.033,
                        depth_rate=0.1),
        "deeper": _insert(0.25, angles=[0.014, 0.0, 0.5], depth=0.052),
    },
    # A side load, then a push that is too small to move the peg under it.
    "jams": {
        "aside": _insert(0.1, place=[-0.002, 0.0]),
        "push": _insert(0.08, depth=0.0213),
        "pushing": _insert(0.1),
    },
    # The same, freed by less side load.
    "is_freed": {
        "aside": _insert(0.1, place=[-0.002, 0.0]),
        "push": _insert(0.08, depth=0.0216),
        "less": _insert(0.1, place=[0.0, 0.0]),
        "rest": _insert(0.1),
    },
}  # fmt: skip


def plan_of(name: str, **more):
    """Return the plan of a program, for `simulation.truth.integrate` as well."""
    tree = {"holder": HOLDER, "start": START, "phases": PROGRAMS[name], **more}
    return plan_from_tree(Configuration(scene=SCENE), tree)
